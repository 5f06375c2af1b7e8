// The glossary page: the names of requests and answers, and the codes with their meanings from docs/codes.md.

import { el } from './dom.js';
import { NAMES } from './terms.js';

document.getElementById('terms').append(el('tbody', {}, Object.entries(NAMES).map(([name, { label, help }]) => el('tr', { id: name }, el('th', { scope: 'row' }, el('code', {}, name)), el('td', {}, label), el('td', {}, help)))));

// Text with `code` in it.
const inline = (text) => text.split('`').map((part, i) => (i % 2 ? el('code', {}, part) : part));
const cells = (row) => row.split('|').slice(1, -1).map((cell) => cell.trim());

/** A section of the page of codes: a heading, paragraphs and one table. */
function section(text) {
  const [heading, ...lines] = text.split('\n');
  const rows = lines.filter((line) => line.startsWith('|'));
  const prose = lines.filter((line) => !line.startsWith('|')).join('\n').split('\n\n').filter((paragraph) => paragraph.trim());
  const table = rows.length > 2 && el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': heading }, el('table', {}, el('thead', {}, el('tr', {}, cells(rows[0]).map((cell) => el('th', { scope: 'col' }, cell)))), el('tbody', {}, rows.slice(2).map((row) => el('tr', {}, cells(row).map((cell) => el('td', {}, inline(cell))))))));
  return el('section', {}, el('h3', {}, heading), prose.map((paragraph) => el('p', {}, inline(paragraph))), table);
}

const text = await (await fetch('workbench/codes.md')).text();
document.getElementById('codes').append(...text.split(/^## /m).slice(1).map(section));
