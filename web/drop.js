// A file that is dropped anywhere on the page, and the view that it is for.

const LIBRARY = /\.(json|tools|fctb|tooldb)$/i;
const PROGRAM = /\.(nc|ngc|gcode|g|tap|cnc|mpf|spf|min|eia|iso|ptp|h|apt|aptsource|cls|cl|ncl)$/i;
const TABLE = /\.(csv|tsv|txt)$/i;
const HEAD_BYTES = 4096;

/** "library", "program", "contacts" or "surface": by the file's name, of a table by the columns of its header. */
export async function kindOf(file) {
  if (LIBRARY.test(file.name)) return 'library';
  if (PROGRAM.test(file.name)) return 'program';
  if (!TABLE.test(file.name)) return 'surface';
  const head = (await file.slice(0, HEAD_BYTES).text()).split(/\r?\n/).filter((line) => line.trim() && !line.startsWith('#') && !/^sep=/i.test(line));
  const header = (head[0] ?? '').toLowerCase();
  if (/\btype\b|tool_type|tool type|\bkind\b/.test(header)) return 'library';
  if (/slope|feed_angle|\bnx\b|normal_x/.test(header)) return 'contacts';
  return /^(%|o\d|[gn]\d|\(|\$\$|partno)/i.test(head[0] ?? '') ? 'program' : 'surface';
}

/** Calls `take(kind, files)` for files that are dropped on the page, files of one kind together. */
export function acceptDrops(take) {
  const isOver = (event, is) => {
    if (![...(event.dataTransfer?.types ?? [])].includes('Files')) return;
    event.preventDefault();
    document.body.classList.toggle('dropping', is);
  };
  document.addEventListener('dragover', (event) => isOver(event, true));
  document.addEventListener('dragleave', (event) => event.relatedTarget === null && isOver(event, false));
  document.addEventListener('drop', async (event) => {
    isOver(event, false);
    const files = [...event.dataTransfer.files];
    const kinds = await Promise.all(files.map(kindOf));
    for (const kind of new Set(kinds)) await take(kind, files.filter((_, i) => kinds[i] === kind));
  });
}
