// Line charts by uPlot, in the colours of the page.

import { el } from './dom.js';

const { uPlot } = globalThis;

const probe = el('span', { hidden: true });
document.body.append(probe);

/** A colour of the style sheet, in the theme in use. */
function colour(variable) {
  probe.style.color = `var(--${variable})`;
  return getComputedStyle(probe).color;
}

const charts = new Set();

/** Draws all charts again, in the colours of the theme and the units in use. */
export function redrawCharts() {
  for (const chart of charts) chart.redraw();
}

/** A chart in a frame with a title. `describe()` returns {x, xLabel, yLabel, series: [{label, colour, values, dash?, points?}], marks, log}. */
export class LineChart {
  #plot = null;
  #describe = null;
  #body = el('div', { class: 'plot' });
  #title = el('h3', {});
  #empty = el('p', { class: 'muted' });

  constructor(title, { height = 220, onPick } = {}) {
    this.height = height;
    this.onPick = onPick;
    this.#title.textContent = title;
    this.element = el('figure', { class: 'chart' }, this.#title, this.#body, this.#empty);
    charts.add(this);
    new ResizeObserver(() => this.#resize()).observe(this.#body);
  }

  #resize() {
    const width = this.#body.clientWidth;
    if (width > 0 && this.#plot && this.#plot.width !== width) this.#plot.setSize({ width, height: this.height });
    else if (width > 0 && !this.#plot) this.redraw();
  }

  show(describe) {
    this.#describe = describe;
    this.redraw();
  }

  /** Shows the reason why there is nothing to draw. */
  clear(reason) {
    this.#describe = null;
    this.#plot?.destroy();
    this.#plot = null;
    this.#empty.textContent = reason ?? '';
  }

  redraw() {
    const width = this.#body.clientWidth;
    if (!this.#describe || width === 0) return;
    this.#plot?.destroy();
    this.#empty.textContent = '';
    const { x, xLabel, yLabel, series, marks = [], yRange } = this.#describe();
    const [ink, grid] = [colour('ink-2'), colour('grid')];
    const axis = { stroke: ink, font: '11px system-ui, sans-serif', labelFont: '11px system-ui, sans-serif', labelSize: 18, labelGap: 2, grid: { stroke: grid, width: 1 }, ticks: { stroke: grid, size: 4 } };
    const options = {
      width,
      height: this.height,
      // Whole pixels would turn slight slopes into steps.
      pxAlign: 0,
      cursor: { points: { size: 6 }, drag: { x: false, y: false } },
      legend: { live: true },
      scales: { x: { time: false }, y: { range: yRange ?? ((_, low, high) => [Math.min(0, low), high > 0 ? high * 1.06 : 1]) } },
      axes: [{ ...axis, label: xLabel, size: 30 }, { ...axis, label: yLabel, size: 48 }],
      series: [
        { label: xLabel, value: (_, value) => shortNumber(value) },
        ...series.map(({ label, colour: name, dash, width: stroke = 1.75, points, gaps }) => ({ label, stroke: colour(name), width: stroke, dash, points: { show: points ?? false }, spanGaps: gaps ?? false, value: (_, value) => shortNumber(value) })),
      ],
      hooks: { draw: [(plot) => drawMarks(plot, marks)] },
    };
    this.#plot = new uPlot(options, [x, ...series.map(({ values }) => values)], this.#body);
    this.#plot.root.querySelector('canvas')?.setAttribute('role', 'img');
    this.#plot.root.querySelector('canvas')?.setAttribute('aria-label', `${this.#title.textContent}: ${series.map(({ label }) => label).join(', ')} over ${xLabel}`);
    if (this.onPick) {
      this.#plot.over.addEventListener('click', () => {
        const { idx } = this.#plot.cursor;
        if (idx !== null && idx !== undefined) this.onPick(idx);
      });
    }
  }
}

const shortNumber = (value) => (value === null || value === undefined ? '–' : String(Number(value.toPrecision(4))));

// Marks: {x} a vertical line, {y} a horizontal one, {x, y} a point; each with a colour's name.
function drawMarks(plot, marks) {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  for (const { x, y, colour: name } of marks) {
    ctx.strokeStyle = ctx.fillStyle = colour(name);
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([4 * devicePixelRatio, 3 * devicePixelRatio]);
    const left = x === undefined ? 0 : plot.valToPos(x, 'x', true);
    const top = y === undefined ? 0 : plot.valToPos(y, 'y', true);
    ctx.beginPath();
    if (x !== undefined && y !== undefined) {
      ctx.arc(left, top, 4 * devicePixelRatio, 0, 2 * Math.PI);
      ctx.fill();
    } else if (x !== undefined) {
      ctx.moveTo(left, bbox.top);
      ctx.lineTo(left, bbox.top + bbox.height);
      ctx.stroke();
    } else {
      ctx.moveTo(bbox.left, top);
      ctx.lineTo(bbox.left + bbox.width, top);
      ctx.stroke();
    }
  }
  ctx.restore();
}
