// The overlays of the map from above: the tip's path, its direction, the selected box, the cross, and the scale.

import { factorOf, roundStep, unitOf } from '../units.js';
import { OPERATIONS } from './palette.js';

const INK = 'rgb(20 30 40)';

/** The map's position on the canvas: conversion of points in mm to pixels and back, and the pixels of a cell's centre. */
export class Placement {
  constructor({ columns, rows, cell_mm: cell, origin_mm: origin }, width, height) {
    this.width = width;
    this.height = height;
    this.scale = Math.min(width / columns, height / rows);
    this.left = (width - columns * this.scale) / 2;
    this.top = (height - rows * this.scale) / 2;
    this.perMillimetre = this.scale / cell;
    this.columns = columns;
    this.rows = rows;
    this.origin = origin;
  }

  toScreen([x, y]) {
    return [this.left + (x - this.origin[0]) * this.perMillimetre, this.top + this.rows * this.scale - (y - this.origin[1]) * this.perMillimetre];
  }

  toPart([left, top]) {
    return [this.origin[0] + (left - this.left) / this.perMillimetre, this.origin[1] + (this.top + this.rows * this.scale - top) / this.perMillimetre];
  }

  middleOf({ column, row }) {
    return [this.left + (column + 0.5) * this.scale, this.top + (this.rows - 0.5 - row) * this.scale];
  }

  /** The cell at a point of the canvas; null outside of the map. */
  cellAt([left, top]) {
    const column = Math.floor((left - this.left) / this.scale);
    const row = this.rows - 1 - Math.floor((top - this.top) / this.scale);
    return column >= 0 && row >= 0 && column < this.columns && row < this.rows ? { column, row } : null;
  }
}

// A move that ends closer than this to the last drawn point, in pixels, is not seen.
const SHORTEST_MOVE = 0.7;

/** The tip's path {x, y, isRapid, operation, count}: moves at the feed rate drawn through in the colour of their operation, rapid moves dotted. */
export function drawPath(context, place, path) {
  context.lineWidth = 0.7;
  for (const [operation, colour] of OPERATIONS.entries()) {
    context.strokeStyle = colour;
    for (const rapid of [0, 1]) strokeMoves(context, place, path, operation, rapid);
  }
  context.setLineDash([]);
  context.globalAlpha = 1;
}

function strokeMoves(context, place, { x, y, isRapid, operation: operations, count }, operation, rapid) {
  context.globalAlpha = rapid ? 0.8 : 0.55;
  context.setLineDash(rapid ? [1.5, 3] : []);
  context.beginPath();
  let last = null;
  for (let i = 1; i < count; i += 1) {
    if (isRapid[i] !== rapid || operations[i] !== operation) {
      last = null;
      continue;
    }
    const at = place.toScreen([x[i], y[i]]);
    if (!last) context.moveTo(...place.toScreen([x[i - 1], y[i - 1]]));
    else if (Math.abs(at[0] - last[0]) + Math.abs(at[1] - last[1]) < SHORTEST_MOVE && isRapid[i + 1] === rapid) continue;
    context.lineTo(...at);
    last = at;
  }
  context.stroke();
}

/** The colours of places by their code. */
export const PLACES = { gouge: '#c21f2e', collision: '#c21f2e', 'over-tolerance': '#e0701f', 'feed-too-high': '#b58a00', 'feed-over-limit': '#b58a00', uncut: '#7a2f86' };

/** Dots at the places [{code, point_mm}]. */
export function drawPlaces(context, place, places) {
  context.lineWidth = 1.5;
  context.strokeStyle = 'white';
  for (const { code, point_mm: point } of places) {
    context.fillStyle = PLACES[code];
    context.beginPath();
    context.arc(...place.toScreen(point), 4, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }
}

// A plate in the colour of the card, so that its content is legible over the part.
function plate(context, [left, top, width, height], colour) {
  context.fillStyle = colour;
  context.globalAlpha = 0.88;
  context.beginPath();
  context.roundRect(left, top, width, height, 4);
  context.fill();
  context.globalAlpha = 1;
}

/** A double arrow along the passes, at the upper right. */
export function drawDirection(context, place, degrees, { ink, card }) {
  const [x, y, reach] = [place.width - 28, 28, 15];
  plate(context, [x - 22, y - 22, 44, 44], card);
  const angle = (-degrees * Math.PI) / 180;
  context.save();
  context.translate(x, y);
  context.rotate(angle);
  context.strokeStyle = context.fillStyle = ink;
  context.lineWidth = 1.6;
  context.beginPath();
  context.moveTo(-reach, 0);
  context.lineTo(reach, 0);
  context.stroke();
  for (const sign of [-1, 1]) {
    context.beginPath();
    context.moveTo(sign * (reach + 3), 0);
    context.lineTo(sign * (reach - 5), 4);
    context.lineTo(sign * (reach - 5), -4);
    context.fill();
  }
  context.restore();
}

export function drawCross(context, place, cell) {
  const [x, y] = place.middleOf(cell);
  for (const [colour, width] of [['white', 3], [INK, 1]]) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.beginPath();
    context.moveTo(x - 9, y);
    context.lineTo(x + 9, y);
    context.moveTo(x, y - 9);
    context.lineTo(x, y + 9);
    context.stroke();
  }
}

/** A box {min: [x, y], max: [x, y]} in mm. */
export function drawBox(context, place, { min, max }) {
  const [left, bottom] = place.toScreen(min);
  const [right, top] = place.toScreen(max);
  context.setLineDash([5, 4]);
  for (const [colour, width] of [['white', 3], [INK, 1.2]]) {
    context.strokeStyle = colour;
    context.lineWidth = width;
    context.strokeRect(left, top, right - left, bottom - top);
  }
  context.setLineDash([]);
}

export function drawScale(context, place, { ink, card }) {
  const factor = factorOf('length');
  const length = roundStep((place.width * 0.18 * factor) / place.perMillimetre) / factor;
  const text = `${Number((length * factor).toPrecision(3))} ${unitOf('length')} · X →, Y ↑`;
  const bottom = place.height;
  context.font = '11px system-ui, sans-serif';
  plate(context, [4, bottom - 30, Math.max(length * place.perMillimetre, context.measureText(text).width + 6) + 8, 26], card);
  context.strokeStyle = context.fillStyle = ink;
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(8, bottom - 13);
  context.lineTo(8, bottom - 9);
  context.lineTo(8 + length * place.perMillimetre, bottom - 9);
  context.lineTo(8 + length * place.perMillimetre, bottom - 13);
  context.stroke();
  context.fillText(text, 12, bottom - 16);
}
