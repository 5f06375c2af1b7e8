// The moves of a plan's program, for drawing: what is drawn is the path that is downloaded. Only the service's own programs are read, which
// have G0 and G1 alone; other programs are the service's to read.

const INCH = 25.4;

/** The moves of `text` as {x, y, z, isRapid, operation, count}: positions in mm in the order of the program, each with the number of tool calls before it, less one; the zero point of the program is at `origin`. */
export function movesOf(text, origin = [0, 0, 0]) {
  const most = text.split('\n').length;
  const [x, y, z, isRapid, operation] = [new Float32Array(most), new Float32Array(most), new Float32Array(most), new Uint8Array(most), new Uint8Array(most)];
  const factor = /^.*\bG20\b/m.test(text.slice(0, 400)) ? INCH : 1;
  const at = { X: null, Y: null, Z: null };
  let [count, rapid, calls] = [0, 1, 0];
  for (const line of text.split('\n')) {
    if (/^(?:N\d+ )?T\d+ M6/.test(line)) calls += 1;
    if (!/^(?:N\d+ )?[GXYZ]/.test(line)) continue;
    let moved = false;
    for (const [, letter, number] of line.matchAll(/([GXYZ])(-?[\d.]+)/g)) {
      if (letter === 'G') {
        if (number === '0' || number === '1') rapid = number === '0' ? 1 : 0;
      } else {
        at[letter] = Number(number) * factor;
        moved = true;
      }
    }
    if (!moved || at.X === null || at.Y === null || at.Z === null) continue;
    [x[count], y[count], z[count], isRapid[count], operation[count]] = [at.X + origin[0], at.Y + origin[1], at.Z + origin[2], rapid, Math.max(0, calls - 1)];
    count += 1;
  }
  return { x, y, z, isRapid, operation, count };
}
