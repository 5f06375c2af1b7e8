// Reads a tool library for the table of cutters: Fusion's JSON and `.tools`, FreeCAD's `.fctb` and zips of them, CSV. A library that the page
// cannot read is sent to the service as it is, which names its faults.

import { csvTools } from './csv.js';
import { freecadTool } from './freecad.js';
import { fusionTools } from './fusion.js';
import { filesOfZip } from './zip.js';

const LARGEST = 20e6;

function toolsOf(text) {
  if (!/^\s*[[{]/.test(text)) return csvTools(text);
  const content = JSON.parse(text);
  if (Array.isArray(content.data)) return fusionTools(content.data);
  return content.parameter ? [freecadTool(content)] : null;
}

async function toolsOfZip(bytes) {
  const found = [];
  const files = filesOfZip(bytes);
  // Lists say which tools belong to a library; the service reads them.
  if (files.some(({ name }) => /\.fctl$/i.test(name))) return null;
  for (const file of files) {
    if (!/\.(json|fctb|csv|tsv|txt)$/i.test(file.name) || /(^|\/)[._]/.test(file.name)) continue;
    const tools = toolsOf(new TextDecoder().decode(await file.bytes()));
    if (!tools) return null;
    found.push(...tools);
  }
  return found;
}

/** {tools, others: [[kind, count]]} of a file; null if the page cannot read it. */
export async function readLibrary(file) {
  if (file.size > LARGEST) return null;
  try {
    const bytes = new Uint8Array(await file.arrayBuffer());
    const isZip = bytes[0] === 0x50 && bytes[1] === 0x4b;
    const read = isZip ? await toolsOfZip(bytes) : toolsOf(new TextDecoder('utf-8', { fatal: true }).decode(bytes));
    if (!read) return null;
    const others = new Map();
    for (const { other } of read) if (other) others.set(other, (others.get(other) ?? 0) + 1);
    const tools = read.filter(({ tool }) => tool).map(({ tool }, i) => ({ ...tool, name: String(tool.name ?? `tool ${tool.number ?? i + 1}`).trim().slice(0, 100) }));
    return { tools, others: [...others] };
  } catch {
    return null;
  }
}
