// The turned view of the part: the map's raster as a relief, drawn from back to front.

const MOST_CELLS = 140;

/**
 * Draws the raster {columns, rows, cell_mm, z_mm} into `context` of the given size, seen from `yaw` and `pitch` (radians). `shade(index)`
 * gives a cell's colour as [red, green, blue].
 */
export function drawRelief(context, { columns, rows, z_mm: z }, cell, { width, height, yaw, pitch }, shade) {
  const stride = Math.max(1, Math.ceil(Math.max(columns, rows) / MOST_CELLS));
  const [c, s, sp, cp] = [Math.cos(yaw), Math.sin(yaw), Math.sin(pitch), Math.cos(pitch)];
  let [low, high] = [Infinity, -Infinity];
  for (const value of z) {
    if (value === null) continue;
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  const across = Math.hypot(columns, rows) * cell;
  const scale = Math.min(width / across, height / (across * sp + (high - low) * cp)) * 0.96;
  const [midX, midY, midZ] = [((columns - 1) * cell) / 2, ((rows - 1) * cell) / 2, (low + high) / 2];
  const project = (column, row) => {
    const value = z[row * columns + column];
    if (value === null) return null;
    const [x, y] = [column * cell - midX, row * cell - midY];
    const [u, v] = [x * c - y * s, x * s + y * c];
    return [width / 2 + u * scale, height / 2 - (v * sp + (value - midZ) * cp) * scale];
  };
  // Far cells first: those with the largest depth x sin(yaw) + y cos(yaw).
  const order = (count, forward) => {
    const found = [];
    for (let i = 0; i + stride < count; i += stride) found.push(i);
    return forward ? found : found.reverse();
  };
  const columnOrder = order(columns, s < 0);
  const rowOrder = order(rows, c < 0);
  context.lineWidth = 0.6;
  for (const row of rowOrder) {
    for (const column of columnOrder) {
      const corners = [project(column, row), project(column + stride, row), project(column + stride, row + stride), project(column, row + stride)];
      if (corners.includes(null)) continue;
      const [red, green, blue] = shade(row * columns + column);
      context.fillStyle = context.strokeStyle = `rgb(${red | 0} ${green | 0} ${blue | 0})`;
      context.beginPath();
      corners.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.closePath();
      context.fill();
      context.stroke();
    }
  }
}
