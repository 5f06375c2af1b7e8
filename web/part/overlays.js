// The overlays of the map from above: passes, their direction, the selected box, the cross, and the scale.

import { factorOf, roundStep, unitOf } from '../units.js';

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

export function drawPasses(context, place, { run_starts: starts, contact_mm: contacts }) {
  const stride = Math.max(1, Math.ceil(contacts.length / 100_000));
  context.strokeStyle = INK;
  context.globalAlpha = 0.55;
  context.lineWidth = 0.7;
  context.beginPath();
  starts.forEach((start, run) => {
    const end = starts[run + 1] ?? contacts.length;
    let isDown = false;
    for (let i = start; i < end; i += 1) {
      if ((i - start) % stride !== 0 && i !== end - 1) continue;
      if (contacts[i] === null) {
        isDown = false;
        continue;
      }
      const [x, y] = place.toScreen(contacts[i]);
      if (isDown) context.lineTo(x, y);
      else context.moveTo(x, y);
      isDown = true;
    }
  });
  context.stroke();
  context.globalAlpha = 1;
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
