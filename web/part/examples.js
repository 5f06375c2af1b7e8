// Surfaces to try the part view with, as the service takes them in JSON and as files.

/** A hill with a groove 2 mm deep, rounded to 4.3 mm at its bottom, which large cutters cannot reach: a grid of 109 x 73 points. */
function grooved() {
  const [columns, rows, cell, depth, halfWidth] = [109, 73, 0.5, 2, 6.5];
  const points = [];
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const [x, y] = [column * cell, row * cell];
      const ground = 4 * Math.exp(-(((x - 17) / 15) ** 2) - ((y - 18) / 18) ** 2) + 0.06 * x + 0.9 * Math.sin(y / 9);
      const offset = x - 40 - 3 * Math.sin(y / 10);
      const groove = Math.abs(offset) < halfWidth ? (depth / 2) * (1 + Math.cos((Math.PI * offset) / halfWidth)) : 0;
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
  ['grooved', 'Hill with a groove, 54 × 36 mm', async () => grooved()],
];

// Bernstein polynomials of the degree `degree` at `t`.
function bernstein(degree, t) {
  let weights = [1];
  for (let i = 0; i < degree; i += 1) weights = [...weights, 0].map((weight, j) => weight * (1 - t) + (j > 0 ? weights[j - 1] * t : 0));
  return weights;
}

// The corners of the parameter quads into which the service divides a patch.
function gridOfPatch({ bezier: { control_points: controls }, samples }) {
  const at = (i, j) => {
    const [u, v] = [bernstein(controls.length - 1, i / samples), bernstein(controls[0].length - 1, j / samples)];
    return [0, 1, 2].map((axis) => u.reduce((sum, weight, a) => sum + weight * v.reduce((inner, other, b) => inner + other * controls[a][b][axis], 0), 0));
  };
  const steps = Array.from({ length: samples + 1 }, (_, i) => i);
  return { rows: samples + 1, columns: samples + 1, points: steps.flatMap((i) => steps.map((j) => at(i, j))) };
}

/** An example as an OBJ file: tool libraries can only be sent beside a file. */
export function fileOfSurface(surface, name) {
  const { rows, columns, points } = surface.grid ?? gridOfPatch(surface);
  const lines = points.map((point) => `v ${point.join(' ')}`);
  const [origin, next, above] = [points[0], points[1], points[columns]];
  // Normals point up where the corners run counter-clockwise seen from above.
  const isUp = (next[0] - origin[0]) * (above[1] - origin[1]) > (next[1] - origin[1]) * (above[0] - origin[0]);
  for (let row = 0; row + 1 < rows; row += 1) {
    for (let column = 0; column + 1 < columns; column += 1) {
      const corner = row * columns + column + 1;
      const quad = [corner, corner + 1, corner + columns + 1, corner + columns];
      lines.push(`f ${(isUp ? quad : quad.reverse()).join(' ')}`);
    }
  }
  return new File([`${lines.join('\n')}\n`], `${name}.obj`, { type: 'model/obj' });
}
