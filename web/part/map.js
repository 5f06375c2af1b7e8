// The map of the part: the service's raster seen from above or in 3D, coloured by slope, scallop height, uncut height or Z, with a legend and
// the values under the pointer or the keyboard's cross. Dragging over the map from above selects a box.

import { el, onWidth } from '../dom.js';
import { Field } from '../fields.js';
import { TERMS } from '../terms.js';
import { format, formatWithUnit, unitOf } from '../units.js';
import { colouringOf } from './colouring.js';
import { legendOf } from './legend.js';
import { hex } from './palette.js';
import { movesOf } from './program.js';
import { Placement, drawBox, drawCross, drawDirection, drawPath, drawPlaces, drawScale } from './overlays.js';

// [member of the map, label, name in the glossary]
const LAYERS = [['scallop_height_mm', 'Scallop height', 'scallop_height_mm'], ['slope_deg', 'Slope', 'slope_deg'], ['uncut_mm', 'Uncut', 'uncut_mm'], ['z_mm', 'Height', 'height_over_datum']];
const [LOWEST, TALLEST] = [280, 560];
// A shorter drag is a click.
const SHORTEST_DRAG = 6;

export class PartMap {
  #map = null;
  #shown = {};
  #width = 0;
  #place = null;
  // The 3D view, once it was asked for.
  #solid = null;
  #toolAt = null;
  #cross = null;
  #dragFrom = null;
  #box = null;
  #isDue = false;
  #onBox;
  #canvas = el('canvas', { tabindex: '0', role: 'img', 'aria-label': 'Map of the part. Arrow keys move the cross.' });
  #solidCanvas = el('canvas', { class: 'solid', tabindex: '0', role: 'img', hidden: true, 'aria-label': 'The part in 3D. Arrow keys turn it, plus and minus zoom, page keys move the tool along its path.' });
  #legend = el('div', { class: 'map-legend' });
  #readout = el('p', { class: 'readout', 'aria-live': 'polite' });
  #caption = el('p', { class: 'muted' });
  #layer = new Field({ name: 'layer', label: 'Colour by', help: 'What the colours of the map show.', choices: LAYERS, segmented: true, value: 'scallop_height_mm' }, () => this.draw());
  #view = new Field({ name: 'view', label: 'View', help: 'The part from above, or in 3D: drag to turn, scroll to zoom; arrow keys turn, + and − zoom, page keys move the tool.', choices: [['above', 'From above'], ['solid', '3D']], segmented: true, value: 'above' }, () => this.draw());

  #passes = new Field({ name: 'path', label: 'Tool path', help: 'The tip’s path of the program, over the colours; rapid moves are dotted.', choices: [['no', 'Off'], ['yes', 'On']], segmented: true, value: 'no' }, () => this.draw());

  /** `onBox({min: [x, y], max: [x, y]})` is called, in mm, when a box was dragged over the map; null if boxes are not selected. */
  constructor(onBox) {
    this.#onBox = onBox;
    this.element = el('div', { class: 'map' }, el('div', { class: 'map-controls' }, this.#layer.element, this.#view.element, this.#passes.element), this.#caption, this.#canvas, this.#solidCanvas, this.#legend, this.#readout);
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

  /** Shows the raster `map` with {tolerance in mm, direction in degrees, program?, operations?, places?, cutter?, file?, caption, more?: [words, action], layer?}; `operations` are the colours of the program's operations with their words. */
  show(map, shown) {
    [this.#map, this.#shown, this.#cross, this.#box, this.#toolAt] = [map, shown, null, null, null];
    if (shown.layer) this.#layer.set(shown.layer);
    const isLayer = ([name]) => map[name] !== undefined;
    for (const [name] of LAYERS) this.#layer.element.querySelector(`input[value="${name}"] + label`).hidden = map[name] === undefined;
    if (!map[this.#layer.value]) this.#layer.set(LAYERS.find(isLayer)[0]);
    const [more, onMore] = shown.more ?? [];
    this.#caption.replaceChildren(shown.caption, more ? el('button', { type: 'button', class: 'quiet', onclick: onMore }, more) : '');
    this.draw();
  }

  /** The drawing as the address of an image. */
  image() {
    return this.#canvas.toDataURL('image/png');
  }

  // The moves of the program, read when they are first drawn.
  get #path() {
    if (this.#shown.program) this.#shown.path ??= movesOf(this.#shown.program, this.#shown.origin);
    return this.#shown.path;
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
    const { columns, rows } = this.#map;
    const height = Math.min(Math.max((this.#width * rows) / columns, LOWEST), TALLEST);
    this.#place = new Placement(this.#map, this.#width, height);
    const ratio = globalThis.devicePixelRatio || 1;
    this.#canvas.width = this.#width * ratio;
    this.#canvas.height = height * ratio;
    this.#canvas.style.height = `${height}px`;
    // Drawn on change alone and read for the setup sheet: by the processor it takes less time than by a slow graphics card.
    const context = this.#canvas.getContext('2d', { willReadFrequently: true });
    context.scale(ratio, ratio);
    const [layer, label, term] = LAYERS.find(([name]) => name === this.#layer.value);
    const { scale, colourOf, keys } = colouringOf(this.#map, layer, this.#shown.tolerance);
    this.#drawAbove(context, colourOf);
    this.#canvas.hidden = this.#isSolid;
    this.#solidCanvas.hidden = !this.#isSolid;
    if (this.#isSolid) this.#drawSolid(colourOf);
    this.#passes.element.hidden = !this.#shown.program;
    const operations = this.#passes.value === 'yes' ? (this.#shown.operations ?? []).map(([text, colour]) => [text, hex(colour)]) : [];
    this.#legend.replaceChildren(...legendOf({ label, kind: TERMS[term].kind }, scale, Math.min(this.#width, 420), [...keys, ...operations]));
    this.#showReadout();
  }

  #drawAbove(context, colour) {
    const { columns, rows, z_mm: z } = this.#map;
    const { direction, box, places } = this.#shown;
    const image = new ImageData(columns, rows);
    for (let index = 0; index < columns * rows; index += 1) {
      if (z[index] === null) continue;
      // Rows run from the lowest y; the image's from the top.
      const at = 4 * ((rows - 1 - Math.floor(index / columns)) * columns + (index % columns));
      image.data.set(colour(index), at);
      image.data[at + 3] = 255;
    }
    const raster = new OffscreenCanvas(columns, rows);
    raster.getContext('2d', { willReadFrequently: true }).putImageData(image, 0, 0);
    const place = this.#place;
    context.imageSmoothingEnabled = false;
    context.drawImage(raster, place.left, place.top, columns * place.scale, rows * place.scale);
    const colours = { ink: getComputedStyle(this.#canvas).color, card: getComputedStyle(this.element.parentElement).backgroundColor };
    if (this.#passes.value === 'yes' && this.#path) drawPath(context, place, this.#path);
    if (places) drawPlaces(context, place, places);
    if (this.#box ?? box) drawBox(context, place, this.#box ?? box);
    if (this.#cross) drawCross(context, place, this.#cross);
    if (typeof direction === 'number') drawDirection(context, place, direction, colours);
    drawScale(context, place, colours);
  }

  #at(event) {
    const box = this.#canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  get #isSolid() {
    return this.#view.value === 'solid';
  }

  // The 3D view is loaded when it is first shown. Without WebGL the map from above stays.
  async #drawSolid(colourOf) {
    const { SolidView, isPossible } = await import('../solid/view.js');
    if (!this.#solid && !isPossible()) {
      this.#view.set('above');
      this.draw();
      this.#readout.textContent = 'This browser has no WebGL 2, which the 3D view needs.';
      return;
    }
    this.#solid ??= new SolidView(this.#solidCanvas, (cell, move) => {
      [this.#cross, this.#toolAt] = [cell, move];
      this.#showReadout();
    });
    const { places, cutter, file } = this.#shown;
    const path = this.#path;
    this.#solid.resize(this.#width, Math.min(TALLEST, Math.max(LOWEST, this.#width * 0.66)));
    const shown = { map: this.#map, colourOf, places, cutter, path: this.#passes.value === 'yes' ? path : undefined, tips: path, file: await file?.() };
    if (this.#isSolid) await this.#solid.show(shown);
    this.#showReadout();
    this.#solidCanvas.dataset.shown = String(Number(this.#solidCanvas.dataset.shown ?? 0) + 1);
  }

  #press(event) {
    if (event.button !== 0) return;
    this.#canvas.setPointerCapture(event.pointerId);
    // A finger scrolls the page.
    if (this.#onBox && event.pointerType !== 'touch') this.#dragFrom = this.#at(event);
  }

  #move(event) {
    if (!this.#map) return;
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
    if (!this.#cross) {
      const tool = this.#isSolid && this.#toolAt !== null && this.#path;
      const coarse = this.#solid?.isCoarse ? ' Its facets would be slow to draw on this computer: the cells of the map are drawn.' : '';
      this.#readout.textContent = tool ? this.#toolText(tool) : this.#isSolid ? `Drag to turn the part, scroll to zoom, point at it to see the tool there.${coarse}` : `Point at the part to read its values${this.#onBox ? '; drag to select a box' : ''}.`;
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
    parts.push((scallop?.[index] ?? null) === null ? 'no scallop height' : `scallop ${formatWithUnit(scallop[index], 'height')}`);
    if (uncut?.[index] > 0) parts.push(`uncut ${formatWithUnit(uncut[index], 'height')}`);
    if (this.#isSolid && this.#toolAt !== null && this.#path) parts.push(this.#toolText(this.#path));
    this.#readout.textContent = parts.join(' · ');
  }

  // Where the tool's tip is.
  #toolText({ x, y, z }) {
    return `tip at ${[x, y, z].map((part) => format(part[this.#toolAt], 'length')).join(', ')} ${unitOf('length')}`;
  }
}
