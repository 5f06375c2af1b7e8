// The map of the part: the service's raster seen from above or turned, coloured by slope, scallop height, uncut height or Z, with a
// legend and the values under the pointer or the keyboard's cross. Dragging over the map from above selects a box.

import { el, onWidth } from '../dom.js';
import { Field } from '../fields.js';
import { TERMS } from '../terms.js';
import { format, formatWithUnit, unitOf } from '../units.js';
import { legendOf } from './legend.js';
import { Placement, drawBox, drawCross, drawDirection, drawPasses, drawScale } from './overlays.js';
import { NO_VALUE, scaleOf } from './palette.js';
import { drawRelief } from './relief.js';

// [member of the map, label, name in the glossary, what a cell without a value is]
const LAYERS = [
  ['scallop_height_mm', 'Scallop height', 'scallop_height_mm', 'not machined, or uncut'],
  ['slope_deg', 'Slope', 'slope_deg', 'no slope'],
  ['uncut_mm', 'Uncut', 'uncut_mm', 'not machined'],
  ['z_mm', 'Height', 'height_over_datum', 'no surface'],
];
const [LOWEST, TALLEST] = [280, 560];
// A shorter drag is a click.
const SHORTEST_DRAG = 6;

export class PartMap {
  #map = null;
  #shown = {};
  #width = 0;
  #place = null;
  #turn = { yaw: 0.6, pitch: 0.75 };
  #cross = null;
  #dragFrom = null;
  #box = null;
  #isDue = false;
  #onBox;
  #canvas = el('canvas', { tabindex: '0', role: 'img', 'aria-label': 'Map of the part. Arrow keys move the cross, or turn the part in the turned view.' });
  #legend = el('div', { class: 'map-legend' });
  #readout = el('p', { class: 'readout', 'aria-live': 'polite' });
  #caption = el('p', { class: 'muted' });
  #layer = new Field({ name: 'layer', label: 'Colour by', help: 'What the colours of the map show.', choices: LAYERS, segmented: true, value: 'scallop_height_mm' }, () => this.draw());
  #view = new Field({ name: 'view', label: 'View', help: 'The part from above, or turned: drag it, or use the arrow keys.', choices: [['above', 'From above'], ['turned', 'Turned']], segmented: true, value: 'above' }, () => this.draw());

  /** `onBox({min: [x, y], max: [x, y]})` is called, in mm, when a box was dragged over the map. */
  constructor(onBox) {
    this.#onBox = onBox;
    this.element = el('div', { class: 'map' }, el('div', { class: 'map-controls' }, this.#layer.element, this.#view.element), this.#caption, this.#canvas, this.#legend, this.#readout);
    onWidth(this.element, (width) => {
      this.#width = width;
      this.draw();
    });
    this.#canvas.addEventListener('pointermove', (event) => this.#move(event));
    this.#canvas.addEventListener('pointerleave', () => this.#dragFrom || this.#point(null));
    this.#canvas.addEventListener('pointerdown', (event) => this.#press(event));
    this.#canvas.addEventListener('pointerup', () => this.#release());
    this.#canvas.addEventListener('pointercancel', () => this.#release());
    this.#canvas.addEventListener('keydown', (event) => this.#key(event));
  }

  /** Shows the raster `map` with {tolerance in mm, direction in degrees, passes?, caption, layer?}. */
  show(map, shown) {
    [this.#map, this.#shown, this.#cross, this.#box] = [map, shown, null, null];
    if (shown.layer) this.#layer.set(shown.layer);
    this.#caption.textContent = shown.caption;
    this.draw();
  }

  // One drawing for all events of a frame.
  #drawSoon() {
    if (this.#isDue) return;
    this.#isDue = true;
    requestAnimationFrame(() => {
      this.#isDue = false;
      this.draw();
    });
  }

  draw() {
    if (!this.#map || !this.#width) return;
    const { columns, rows, cell_mm: cell } = this.#map;
    const height = Math.min(Math.max((this.#width * rows) / columns, LOWEST), TALLEST);
    this.#place = new Placement(this.#map, this.#width, height);
    const ratio = globalThis.devicePixelRatio || 1;
    this.#canvas.width = this.#width * ratio;
    this.#canvas.height = height * ratio;
    this.#canvas.style.height = `${height}px`;
    const context = this.#canvas.getContext('2d');
    context.scale(ratio, ratio);
    const [layer, label, term, grey] = LAYERS.find(([name]) => name === this.#layer.value);
    const values = this.#map[layer];
    const scale = scaleOf(layer, values, this.#shown.tolerance);
    const shade = this.#shading(values, scale);
    if (this.#view.value === 'turned') drawRelief(context, this.#map, cell, { width: this.#width, height, ...this.#turn }, shade);
    else this.#drawAbove(context, shade);
    const hasGrey = values.some((value, index) => value === null && this.#map.z_mm[index] !== null);
    this.#legend.replaceChildren(...legendOf({ label, kind: TERMS[term].kind, grey }, scale, Math.min(this.#width, 420), hasGrey));
    this.#showReadout();
  }

  // A cell's colour, lit from the upper left.
  #shading(values, { colourOf }) {
    const { columns, rows, z_mm: z, cell_mm: cell } = this.#map;
    return (index) => {
      const value = values[index];
      const [column, row] = [index % columns, Math.floor(index / columns)];
      const slopeOf = (a, b, steps) => (z[a] === null || z[b] === null || steps === 0 ? 0 : (z[b] - z[a]) / (steps * cell));
      const [left, right] = [Math.max(column - 1, 0), Math.min(column + 1, columns - 1)];
      const [below, above] = [Math.max(row - 1, 0), Math.min(row + 1, rows - 1)];
      const dx = slopeOf(row * columns + left, row * columns + right, right - left);
      const dy = slopeOf(below * columns + column, above * columns + column, above - below);
      const light = (0.45 * dx - 0.45 * dy + 0.77) / Math.hypot(dx, dy, 1);
      const factor = 0.7 + 0.38 * Math.max(0, Math.min(light, 1));
      return (value === null ? NO_VALUE : colourOf(value)).map((part) => Math.min(255, part * factor));
    };
  }

  #drawAbove(context, shade) {
    const { columns, rows, z_mm: z } = this.#map;
    const { passes, direction, box } = this.#shown;
    const image = new ImageData(columns, rows);
    for (let index = 0; index < columns * rows; index += 1) {
      if (z[index] === null) continue;
      // Rows run from the lowest y; the image's from the top.
      const at = 4 * ((rows - 1 - Math.floor(index / columns)) * columns + (index % columns));
      image.data.set(shade(index), at);
      image.data[at + 3] = 255;
    }
    const raster = new OffscreenCanvas(columns, rows);
    raster.getContext('2d').putImageData(image, 0, 0);
    const place = this.#place;
    context.imageSmoothingEnabled = false;
    context.drawImage(raster, place.left, place.top, columns * place.scale, rows * place.scale);
    const colours = { ink: getComputedStyle(this.#canvas).color, card: getComputedStyle(this.element.parentElement).backgroundColor };
    if (passes) drawPasses(context, place, passes);
    if (this.#box ?? box) drawBox(context, place, this.#box ?? box);
    if (this.#cross) drawCross(context, place, this.#cross);
    if (typeof direction === 'number') drawDirection(context, place, direction, colours);
    drawScale(context, place, colours);
  }

  #at(event) {
    const box = this.#canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  get #isTurned() {
    return this.#view.value === 'turned';
  }

  #press(event) {
    if (event.button !== 0) return;
    this.#canvas.setPointerCapture(event.pointerId);
    // A finger scrolls the page.
    if (!this.#isTurned && event.pointerType !== 'touch') this.#dragFrom = this.#at(event);
  }

  #move(event) {
    if (!this.#map) return;
    if (this.#isTurned) {
      if (event.buttons & 1) {
        this.#turn.yaw += event.movementX / 120;
        this.#turn.pitch = Math.min(1.5, Math.max(0.15, this.#turn.pitch + event.movementY / 150));
        this.#drawSoon();
      }
      return;
    }
    const at = this.#at(event);
    if (this.#dragFrom && Math.hypot(at[0] - this.#dragFrom[0], at[1] - this.#dragFrom[1]) >= SHORTEST_DRAG) {
      const [a, b] = [this.#dragFrom, at].map((point) => this.#place.toPart(point));
      this.#box = { min: [Math.min(a[0], b[0]), Math.min(a[1], b[1])], max: [Math.max(a[0], b[0]), Math.max(a[1], b[1])] };
      this.#drawSoon();
    }
    this.#point(this.#place.cellAt(at));
  }

  #release() {
    this.#dragFrom = null;
    if (this.#box) this.#onBox(this.#box);
  }

  #key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step || !this.#map) return;
    event.preventDefault();
    if (this.#isTurned) {
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
    if (!this.#cross || this.#isTurned) {
      this.#readout.textContent = this.#isTurned ? 'Drag the part, or use the arrow keys, to turn it.' : 'Point at the part to read its values; drag to select a box.';
      return;
    }
    const { columns, cell_mm: cell, origin_mm: origin, z_mm: z, slope_deg: slope, scallop_height_mm: scallop, uncut_mm: uncut } = this.#map;
    const { column, row } = this.#cross;
    const index = row * columns + column;
    const position = `X ${format(origin[0] + (column + 0.5) * cell, 'length')}, Y ${format(origin[1] + (row + 0.5) * cell, 'length')}`;
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
