// Surfaces to try the part view with.

/** A pocket floor with a ridge and a groove of 3 mm radius, which large cutters cannot reach: a grid of 121 x 81 points. */
function grooved() {
  const [columns, rows, cell, radius] = [121, 81, 0.75, 3];
  const points = [];
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const [x, y] = [column * cell, row * cell];
      const ground = 9 * Math.exp(-(((x - 30) / 22) ** 2) - ((y - 30) / 26) ** 2) + 0.06 * x + 2.2 * Math.sin(y / 14);
      const offset = x - 68 - 5 * Math.sin(y / 17);
      const groove = Math.abs(offset) < radius * 0.94 ? Math.sqrt(radius * radius - offset * offset) - radius * Math.sqrt(1 - 0.94 ** 2) : 0;
      points.push([Number(x.toFixed(3)), Number(y.toFixed(3)), Number((ground - groove).toFixed(4))]);
    }
  }
  return { grid: { rows, columns, points } };
}

const fetched = (path) => async () => (await fetch(path)).json();

/** [name, label, a function that gives the service's `surface`]. */
export const EXAMPLES = [
  ['surface_1', 'Ruled patch, 42°, 80 × 60 mm', fetched('workbench/examples/surface_1.json')],
  ['surface_2', 'Wavy patch, 17°, 48 × 61 mm', fetched('workbench/examples/surface_2.json')],
  ['grooved', 'Hill with a 3 mm groove, 90 × 60 mm', async () => grooved()],
];
