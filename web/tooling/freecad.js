// A tool of FreeCAD, a `.fctb` file: a shape, and dimensions as text with a unit.

import { countOf, lengthOf, millimetresOf, shaped, typeNamed } from './shape.js';

function length(value) {
  const [, number, unit] = /^\s*(.*[\d.,])\s*(\D*?)\s*$/.exec(String(value ?? '')) ?? [];
  const mm = typeof value === 'number' ? 1 : millimetresOf(unit);
  return number === undefined ? undefined : mm ? lengthOf(number, mm) : String(value);
}

function cornerOf(parameter, diameter) {
  const stated = parameter.CornerRadius ?? parameter.TorusRadius;
  if (stated !== undefined) return { corner_radius_mm: length(stated), cornerIsStated: true };
  if (parameter.FlatRadius === undefined) return {};
  const corner = diameter / 2 - (length(parameter.FlatRadius) ?? 0);
  return { corner_radius_mm: Math.abs(corner) <= 1e-9 * diameter ? undefined : corner, cornerIsStated: true };
}

/** {tool} or {other: kind}. */
export function freecadTool({ name, shape, 'shape-type': shapeType, parameter = {} }) {
  const kind = String(shapeType ?? shape ?? '').split(/[/\\]/).at(-1).replace(/\.[^.]*$/, '');
  const type = typeNamed(kind.replace(/^_*(?:fusion_)?/i, ''));
  if (!type) return { other: kind };
  const diameter = length(parameter.Diameter);
  // The angle is that between the flanks.
  const angle = Number(String(parameter.TaperAngle ?? '').replace(',', '.').replace(/[^\d.]+$/, ''));
  const tapered = type === 'tapered_ball' ? { taper_deg: angle > 0 ? angle / 2 : undefined, shank_diameter_mm: length(parameter.TaperDiameter) ?? length(parameter.ShankDiameter) } : {};
  const cutter = shaped({ type, diameter_mm: diameter, ...cornerOf(parameter, diameter), ...tapered });
  return { tool: { name, ...cutter, teeth: countOf(parameter.Flutes), max_feed_per_tooth_mm: length(parameter.Chipload), flute_length_mm: length(parameter.CuttingEdgeHeight) } };
}
