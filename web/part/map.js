// The map of the part: the service's raster seen from above or turned, coloured by slope, scallop height, uncut height or Z, with a
// legend and the values under the pointer or the keyboard's cross.

import { el, onWidth, svg } from '../dom.js';
import { Field } from '../fields.js';
import { TERMS } from '../terms.js';
import { factorOf, format, formatWithUnit, roundStep, ticks, unitOf } from '../units.js';
import { scaleOf } from './palette.js';
import { drawRelief } from './relief.js';

const LAYERS = [['slope_deg', 'Slope', 'slope_deg'], ['scallop_height_mm', 'Scallop height', 'scallop_height_mm'], ['uncut_mm', 'Uncut', 'uncut_mm'], ['z_mm', 'Height', 'height_over_datum']];
const FLOOR = 300;

export class PartMap {
  #map = null;
  #tolerance = 0.01;
  #passes = null;
  #width = 0;
  #turn = { yaw: 0.6, pitch: 0.75 };
  #cross = null;
  #canvas = el('canvas', { tabindex: '0', role: 'img', 'aria-label': 'Map of the part. Arrow keys move the cross, or turn the part in the turned view.' });
  #legend = el('div', { class: 'map-legend' });
  #readout = el('p', { class: 'readout', 'aria-live': 'polite' });
  #caption = el('p', { class: 'muted' });
  #layer = new Field({ name: 'layer', label: 'Colour by', help: 'What the colours of the map show.', choices: LAYERS, segmented: true, value: 'scallop_height_mm' }, () => this.draw());
  #view = new Field({ name: 'view', label: 'View', help: 'The part from above, or turned: drag it, or use the arrow keys.', choices: [['above', 'From above'], ['turned', 'Turned']], segmented: true, value: 'above' }, () => this.draw());

  constructor() {
    this.element = el('div', { class: 'map' }, el('div', { class: 'map-controls' }, this.#layer.element, this.#view.element), this.#canvas, this.#legend, this.#readout, this.#caption);
    onWidth(this.element, (width) => {
      this.#width = width;
      this.draw();
    });
    this.#canvas.addEventListener('pointermove', (event) => this.#pointer(event));
    this.#canvas.addEventListener('pointerleave', () => this.#point(null));
    this.#canvas.addEventListener('pointerdown', (event) => this.#canvas.setPointerCapture(event.pointerId));
    this.#canvas.addEventListener('keydown', (event) => this.#key(event));
  }

  /** Shows the raster of an answer, `tolerance` in mm, and the passes where the answer has them. */
  show(map, tolerance, passes, caption) {
    [this.#map, this.#tolerance, this.#passes, this.#cross] = [map, tolerance, passes, null];
    this.#caption.textContent = caption;
    this.draw();
  }

  #place() {
    const { columns, rows } = this.#map;
    const height = Math.min(Math.max((this.#width * rows) / columns, FLOOR), 520);
    const scale = Math.min(this.#width / columns, height / rows);
    return { height, scale, left: (this.#width - columns * scale) / 2, top: (height - rows * scale) / 2 };
  }

  draw() {
    if (!this.#map || !this.#width) return;
    const map = this.#map;
    const { height } = this.#place();
    const ratio = globalThis.devicePixelRatio || 1;
    this.#canvas.width = this.#width * ratio;
    this.#canvas.height = height * ratio;
    this.#canvas.style.height = `${height}px`;
    const context = this.#canvas.getContext('2d');
    context.scale(ratio, ratio);
    const layer = this.#layer.value;
    const values = map[layer];
    const scale = scaleOf(layer, values, this.#tolerance);
    const shade = this.#shading(values, scale);
    if (this.#view.value === 'turned') drawRelief(context, map, map.cell_mm, { width: this.#width, height, ...this.#turn }, shade);
    else this.#drawAbove(context, shade);
    this.#drawLegend(layer, scale);
    this.#showReadout();
  }

  // A cell's colour, lit from the upper left.
  #shading(values, { colourOf }) {
    const { columns, rows, z_mm: z, cell_mm: cell } = this.#map;
    return (index) => {
      const value = values[index];
      if (value === null) return [150, 155, 160];
      const [column, row] = [index % columns, Math.floor(index / columns)];
      const slopeOf = (a, b, steps) => (z[a] === null || z[b] === null || steps === 0 ? 0 : (z[b] - z[a]) / (steps * cell));
      const [left, right] = [Math.max(column - 1, 0), Math.min(column + 1, columns - 1)];
      const [below, above] = [Math.max(row - 1, 0), Math.min(row + 1, rows - 1)];
      const dx = slopeOf(row * columns + left, row * columns + right, right - left);
      const dy = slopeOf(below * columns + column, above * columns + column, above - below);
      const light = (0.45 * dx - 0.45 * dy + 0.77) / Math.hypot(dx, dy, 1);
      const factor = 0.62 + 0.48 * Math.max(0, Math.min(light, 1));
      return colourOf(value).map((part) => Math.min(255, part * factor));
    };
  }

  #drawAbove(context, shade) {
    const { columns, rows, z_mm: z } = this.#map;
    const image = new ImageData(columns, rows);
    for (let index = 0; index < columns * rows; index += 1) {
      if (z[index] === null) continue;
      // Rows run from the lowest y; the image's from the top.
      const at = 4 * ((rows - 1 - Math.floor(index / columns)) * columns + (index % columns));
      image.data.set([...shade(index), 255], at);
    }
    const raster = new OffscreenCanvas(columns, rows);
    raster.getContext('2d').putImageData(image, 0, 0);
    const { scale, left, top } = this.#place();
    context.imageSmoothingEnabled = false;
    context.drawImage(raster, left, top, columns * scale, rows * scale);
    if (this.#passes) this.#drawPasses(context);
    if (this.#cross) this.#drawCross(context);
    this.#drawScale(context, scale / this.#map.cell_mm);
  }

  #drawPasses(context) {
    const { run_starts: starts, contact_mm: contacts } = this.#passes;
    const stride = Math.max(1, Math.ceil(contacts.length / 100_000));
    context.strokeStyle = 'rgb(20 30 40 / 0.55)';
    context.lineWidth = 0.7;
    context.beginPath();
    starts.forEach((start, run) => {
      const end = starts[run + 1] ?? contacts.length;
      let pen = false;
      for (let i = start; i < end; i += 1) {
        if ((i - start) % stride !== 0 && i !== end - 1) continue;
        if (contacts[i] === null) {
          pen = false;
          continue;
        }
        const [x, y] = this.#toScreen(contacts[i]);
        if (pen) context.lineTo(x, y);
        else context.moveTo(x, y);
        pen = true;
      }
    });
    context.stroke();
  }

  #toScreen([x, y]) {
    const { origin_mm: origin, cell_mm: cell, rows } = this.#map;
    const { scale, left, top } = this.#place();
    return [left + ((x - origin[0]) / cell + 0.5) * scale, top + (rows - 0.5 - (y - origin[1]) / cell) * scale];
  }

  #drawCross(context) {
    const { scale, left, top } = this.#place();
    const { rows } = this.#map;
    const [x, y] = [left + (this.#cross.column + 0.5) * scale, top + (rows - 0.5 - this.#cross.row) * scale];
    context.strokeStyle = '#111';
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x - 9, y);
    context.lineTo(x + 9, y);
    context.moveTo(x, y - 9);
    context.lineTo(x, y + 9);
    context.stroke();
  }

  #drawScale(context, perMillimetre) {
    const factor = factorOf('length');
    const length = roundStep((this.#width * 0.18 * factor) / perMillimetre) / factor;
    const { height } = this.#place();
    const ink = getComputedStyle(this.#canvas).color;
    const text = `${Number((length * factor).toPrecision(3))} ${unitOf('length')} · X →, Y ↑`;
    context.font = '11px system-ui, sans-serif';
    // A plate under the scale keeps it legible over the part.
    context.fillStyle = getComputedStyle(this.element.parentElement).backgroundColor;
    context.globalAlpha = 0.85;
    context.fillRect(4, height - 28, Math.max(length * perMillimetre, context.measureText(text).width + 4) + 8, 24);
    context.globalAlpha = 1;
    context.strokeStyle = context.fillStyle = ink;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(8, height - 12);
    context.lineTo(8, height - 8);
    context.lineTo(8 + length * perMillimetre, height - 8);
    context.lineTo(8 + length * perMillimetre, height - 12);
    context.stroke();
    context.fillText(text, 12, height - 15);
  }

  #drawLegend(layer, { low, high, tolerance, colourOf }) {
    const [, label, termName] = LAYERS.find(([name]) => name === layer);
    const { kind } = TERMS[termName];
    const factor = factorOf(kind);
    const width = Math.min(this.#width, 420);
    const bar = width - 24;
    const at = (value) => 12 + ((value - low) / (high - low)) * bar;
    const slices = Array.from({ length: 120 }, (_, i) => {
      const [red, green, blue] = colourOf(low + ((high - low) * (i + 0.5)) / 120);
      return svg('rect', { x: 12 + (i * bar) / 120, y: 4, width: bar / 120 + 0.6, height: 10, fill: `rgb(${red | 0} ${green | 0} ${blue | 0})` });
    });
    this.#legend.replaceChildren(svg(
      'svg',
      { width, height: 36, viewBox: `0 0 ${width} 36`, role: 'img', 'aria-label': `${label} from ${formatWithUnit(low, kind)} to ${formatWithUnit(high, kind)}` },
      slices,
      ticks(low * factor, high * factor, 5).map((tick) => svg('text', { x: at(tick / factor), y: 27, 'text-anchor': 'middle' }, String(tick))),
      tolerance && svg('path', { class: 'tolerance-mark', d: `M${at(tolerance)} 1v16` }),
    ), el('span', {}, `${label} (${unitOf(kind)})${tolerance ? `, the mark is the tolerance ${formatWithUnit(tolerance, 'height')}` : ''}`));
  }

  #pointer(event) {
    if (!this.#map) return;
    if (this.#view.value === 'turned') {
      if (event.buttons & 1) {
        this.#turn.yaw += event.movementX / 120;
        this.#turn.pitch = Math.min(1.5, Math.max(0.15, this.#turn.pitch + event.movementY / 150));
        requestAnimationFrame(() => this.draw());
      }
      return;
    }
    const box = this.#canvas.getBoundingClientRect();
    const { scale, left, top } = this.#place();
    const column = Math.floor((event.clientX - box.left - left) / scale);
    const row = this.#map.rows - 1 - Math.floor((event.clientY - box.top - top) / scale);
    const inside = column >= 0 && row >= 0 && column < this.#map.columns && row < this.#map.rows;
    this.#point(inside ? { column, row } : null);
  }

  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step || !this.#map) return;
    event.preventDefault();
    if (this.#view.value === 'turned') {
      this.#turn.yaw += step[0] * 0.1;
      this.#turn.pitch = Math.min(1.5, Math.max(0.15, this.#turn.pitch + step[1] * 0.08));
      this.draw();
      return;
    }
    const { columns, rows } = this.#map;
    const by = event.shiftKey ? 10 : 1;
    const from = this.#cross ?? { column: Math.floor(columns / 2), row: Math.floor(rows / 2) };
    this.#point({ column: Math.min(columns - 1, Math.max(0, from.column + step[0] * by)), row: Math.min(rows - 1, Math.max(0, from.row + step[1] * by)) });
    this.draw();
  }

  #point(cell) {
    this.#cross = cell;
    this.#showReadout();
  }

  #showReadout() {
    if (!this.#cross || this.#view.value === 'turned') {
      this.#readout.textContent = this.#view.value === 'turned' ? 'Drag the part, or use the arrow keys, to turn it.' : 'Point at the part to read its values.';
      return;
    }
    const { columns, cell_mm: cell, origin_mm: origin, z_mm: z, slope_deg: slope, scallop_height_mm: scallop, uncut_mm: uncut } = this.#map;
    const { column, row } = this.#cross;
    const index = row * columns + column;
    const position = `X ${format(origin[0] + column * cell, 'length')}, Y ${format(origin[1] + row * cell, 'length')}`;
    if (z[index] === null) {
      this.#readout.textContent = `${position} ${unitOf('length')}: no surface`;
      return;
    }
    const parts = [`${position}, Z ${formatWithUnit(z[index], 'length')}`, `slope ${formatWithUnit(slope[index], 'angle')}`];
    parts.push(scallop[index] === null ? 'no scallop height' : `scallop ${formatWithUnit(scallop[index], 'height')}`);
    if (uncut[index] > 0) parts.push(`uncut ${formatWithUnit(uncut[index], 'height')}`);
    this.#readout.textContent = parts.join(' · ');
  }
}
