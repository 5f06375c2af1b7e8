// Copying and saving: the clipboard where the browser allows it, a dialogue with the text to copy where it does not (pages over plain
// HTTP from another machine have no clipboard).

import { el } from './dom.js';

/** Copies `text` and shows the success on the button. */
export async function copy(text, button) {
  try {
    await navigator.clipboard.writeText(text);
    const label = button.textContent;
    button.textContent = 'Copied';
    button.disabled = true;
    setTimeout(() => {
      button.textContent = label;
      button.disabled = false;
    }, 1200);
  } catch {
    const area = el('textarea', { readonly: true, rows: '8', 'aria-label': 'Text to copy' });
    area.value = text;
    const dialog = el('dialog', { class: 'copy' }, el('p', {}, 'Copy this text:'), area, el('form', { method: 'dialog' }, el('button', {}, 'Close')));
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
    area.select();
  }
}

/** A text in single quotes for a POSIX shell. */
const quoted = (text) => `'${text.replaceAll("'", `'\\''`)}'`;

// Linux takes arguments of 128 KiB at most.
const LONGEST_ARGUMENT = 100_000;

export function curlOfJson(address, body) {
  const text = JSON.stringify(body);
  const head = `curl -sS ${quoted(address)} \\\n  -H 'content-type: application/json'`;
  if (text.length > LONGEST_ARGUMENT) return `${head} --data-binary @- <<'JSON'\n${text}\nJSON\n`;
  return `${head} \\\n  -d ${quoted(text)}`;
}

/** `parts` are [name, {file} or a text]. */
export function curlOfForm(address, parts) {
  const option = ([name, value]) => (typeof value === 'string' ? `--form-string ${quoted(`${name}=${value}`)}` : `-F ${quoted(`${name}=@"${value.file}"`)}`);
  return [`curl -sS ${quoted(address)}`, ...parts.map((part) => `  ${option(part)}`)].join(' \\\n');
}

/** Offers `text` for download as a file. */
export function save(name, text, type) {
  const address = URL.createObjectURL(new Blob([text], { type }));
  const link = el('a', { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Rows as CSV with a header line. */
export function csvOf(header, rows) {
  const cell = (value) => {
    const text = value === null || value === undefined ? '' : String(value);
    return /[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return [header, ...rows].map((row) => row.map(cell).join(',')).join('\n').concat('\n');
}
