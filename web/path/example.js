// A tool path to try the view with: one pass over a hill, from the wall of a pocket over its top.

/** CSV text with positions, slopes and feed angles, 241 contacts. */
export function examplePath() {
  const rows = ['x,y,z,slope_deg,feed_angle_deg,step_over_mm'];
  for (let i = 0; i <= 240; i += 1) {
    const x = i * 0.4;
    const height = (at, y) => 16 * Math.exp(-(((at - 48) / 24) ** 2) - ((y - 6) / 30) ** 2);
    const z = height(x, 0);
    const step = 1e-4;
    const [dx, dy] = [(height(x + step, 0) - height(x - step, 0)) / (2 * step), (height(x, step) - height(x, -step)) / (2 * step)];
    const slope = (Math.atan(Math.hypot(dx, dy)) * 180) / Math.PI;
    // From the uphill line, which is the gradient's, to the feed along +X.
    const angle = (((-Math.atan2(dy, dx) * 180) / Math.PI) + 360) % 360;
    rows.push([x.toFixed(2), '0', z.toFixed(4), slope.toFixed(4), angle.toFixed(4), '0.62'].join(','));
  }
  return `${rows.join('\n')}\n`;
}
