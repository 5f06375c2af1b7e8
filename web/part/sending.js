// Requests of the part view: JSON for the examples, a form for files, and the curl command of either.

import { curlOfForm, curlOfJson } from '../clipboard.js';
import { addressOf, post, upload } from '../service.js';
import { fileOfSurface } from './examples.js';

const ADDRESS = 'v1/cutter-recommendation';

/** A request {parameters, surface, file, libraries}: the surface is JSON of an example, or a file. Libraries can only be sent beside a file. */
export async function compose(parameters, example, file, libraries) {
  const surface = example ? await example[2]() : null;
  return { parameters, surface, libraries: [...libraries], file: surface && libraries.length > 0 ? fileOfSurface(surface, example[0]) : file };
}

const isJson = ({ surface, libraries }) => surface && libraries.length === 0;

/** Sends a request; `onProgress(share)` gets the share of the bytes that are sent, 1 while the service computes. */
export function send(request, onProgress, signal) {
  const { parameters, surface, file, libraries } = request;
  if (isJson(request)) {
    onProgress(1);
    return post(ADDRESS, { surface, ...parameters }, signal);
  }
  const form = new FormData();
  form.append('parameters', new Blob([JSON.stringify(parameters)], { type: 'application/json' }));
  for (const library of libraries) form.append('library', library);
  form.append('surface', file);
  return upload(`${ADDRESS}/upload`, form, onProgress, signal);
}

export function curlOf(request) {
  const { parameters, surface, file, libraries } = request;
  if (isJson(request)) return curlOfJson(addressOf(ADDRESS), { surface, ...parameters });
  return curlOfForm(addressOf(`${ADDRESS}/upload`), [['surface', { file: file?.name ?? 'part.stl' }], ['parameters', JSON.stringify(parameters)], ...libraries.map(({ name }) => ['library', { file: name }])]);
}

/** The same request for one of its cutters alone, in its direction, with other optional parts of the answer. Null if the page does not know the cutter. */
export function alone({ parameters, ...request }, { cutter, direction_deg: direction }, changes) {
  const known = parameters.cutters?.[cutter];
  if (!known) return null;
  return { ...request, libraries: [], parameters: { ...parameters, cutters: [known], ...(direction !== undefined && { directions_deg: [direction] }), ...changes } };
}

const UNITS_IN_MM = { um: 1e-3, mm: 1, cm: 10, m: 1000, inch: 25.4, foot: 304.8 };

/** A function that gives {bytes, unit in mm} of an STL file, for the 3D view; undefined for other files. */
export function stlOf(file, unit = 'mm') {
  return file && /\.stl$/i.test(file.name) ? async () => ({ bytes: await file.arrayBuffer(), unit: UNITS_IN_MM[unit] ?? 1 }) : undefined;
}
