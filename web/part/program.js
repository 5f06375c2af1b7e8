// The moves of a plan's program, for drawing: what is drawn is the path that is downloaded. Only the service's own programs are read, which
// have G0 and G1, or Klartext's L, alone; other programs are the service's to read.

const INCH = 25.4;

const TOOL_CALL = /^(?:N?\d+ )?(?:T(\d+) M6|TOOL CALL (\d+))/m;

/** The numbers of a program's tool calls, in order. */
export const toolCalls = (text) => [...text.matchAll(new RegExp(TOOL_CALL, 'gm'))].map(([, iso, klartext]) => iso ?? klartext);

/** Whether a program is in Klartext. */
export const isKlartext = (text) => /^(?:\d+ )?BEGIN PGM/.test(text);

/** The moves of `text` as {x, y, z, isRapid, operation, count}: positions in mm in the order of the program, each with the number of tool calls before it, less one; the zero point of the program is at `origin`. */
export function movesOf(text, origin = [0, 0, 0]) {
  const most = text.split('\n').length;
  const [x, y, z, isRapid, operation] = [new Float32Array(most), new Float32Array(most), new Float32Array(most), new Uint8Array(most), new Uint8Array(most)];
  const factor = /^(?:.*\bG20\b|(?:0 )?BEGIN PGM \w+ INCH)/m.test(text.slice(0, 400)) ? INCH : 1;
  const at = { X: null, Y: null, Z: null };
  let [count, rapid, calls] = [0, 1, 0];
  for (const line of text.split('\n')) {
    if (TOOL_CALL.test(line)) calls += 1;
    if (!/^(?:N?\d+ )?(?:[GXYZ]|L )/.test(line)) continue;
    if (/^(?:\d+ )?L /.test(line)) rapid = line.endsWith('FMAX') ? 1 : 0;
    let moved = false;
    for (const [, letter, number] of line.matchAll(/([GXYZ])([-+]?[\d.]+)/g)) {
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
