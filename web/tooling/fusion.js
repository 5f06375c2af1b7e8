// Tools of Autodesk Fusion: `data` of its JSON. Speed and feed come from the preset with "finish" in its name, otherwise from the first.

import { countOf, lengthOf, millimetresOf, shaped, typeNamed } from './shape.js';

/** {tool} or {other: kind} for each tool of `data`. */
export const fusionTools = (data) => data.map(toolOf);

// A tapered mill is stated by the diameter of its cone at the height of the tip. The page's table holds those whose tip is a ball; the service reads
// the others from a library that is uploaded with the part.
function taperedBall({ DC: tip, RE: corner = 0, TA: degrees = 0, SFDM: shank, LCF: flutes }, mm) {
  const taper = (degrees * Math.PI) / 180;
  const ball = ((tip / 2) * Math.cos(taper)) / (1 - Math.sin(taper));
  if (!(Math.abs(corner - ball) <= 0.01 * ball)) return null;
  return { diameter_mm: 2 * ball * mm, taper_deg: degrees, shank_diameter_mm: (shank || tip + 2 * flutes * Math.tan(taper)) * mm };
}

// Fusion's lens has its radius as the lower one, its oval has tip and side.
function segment(kind, geometry, mm) {
  const [lower, side] = [lengthOf(geometry['lower-radius'], mm), lengthOf(geometry['profile-radius'], mm)];
  if (kind === 'lens') return { lens_radius_mm: lower };
  return kind === 'oval' ? { tip_radius_mm: lower, side_radius_mm: side } : {};
}

function toolOf({ type, unit, description, 'product-id': product, geometry = {}, 'start-values': values, 'post-process': post }) {
  const mm = millimetresOf(unit);
  const isTapered = String(type) === 'tapered mill';
  const kind = isTapered ? 'tapered_ball' : typeNamed(String(type));
  if (!kind) return { other: String(type) };
  if (!isTapered && Number(geometry.TA ?? 0) !== 0) return { other: `tapered ${type}` };
  const dimensions = isTapered ? taperedBall(geometry, mm) : segment(kind, geometry, mm);
  if (!dimensions) return { other: `${type} without a ball` };
  const presets = values?.presets ?? [];
  const preset = presets.find(({ name }) => /finish/i.test(name ?? '')) ?? presets[0] ?? {};
  const [teeth, speed] = [countOf(geometry.NOF), countOf(preset.n)];
  const feed = preset.f_z || (preset.v_f && teeth && speed ? preset.v_f / (teeth * speed) : undefined);
  return {
    tool: {
      name: [description, product].find((name) => String(name ?? '').trim()),
      number: post?.number,
      ...shaped({ type: kind, diameter_mm: lengthOf(geometry.DC, mm), corner_radius_mm: lengthOf(geometry.RE, mm), cornerIsStated: geometry.RE !== undefined, ...dimensions }),
      teeth, spindle_speed_rpm: speed, max_feed_per_tooth_mm: lengthOf(feed, mm), flute_length_mm: lengthOf(geometry.LCF, mm), preset: preset.name,
    },
  };
}
