// The glossary page: the names of requests and answers, and the enumerations of the OpenAPI document.

import { el } from './dom.js';
import { OF_THE_PAGE, TERMS } from './terms.js';

document.getElementById('terms').append(el('tbody', {}, Object.entries(TERMS).filter(([name]) => !OF_THE_PAGE.has(name)).map(([name, { label, help }]) => el('tr', { id: name }, el('th', { scope: 'row' }, el('code', {}, name)), el('td', {}, label), el('td', {}, help)))));

/** The values of an enumeration: [value, description]; empty for another schema. */
function valuesOf(schema) {
  if (Array.isArray(schema.enum)) return schema.enum.map((value) => [value, '']);
  const each = (schema.oneOf ?? []).map((one) => [one.const ?? one.enum?.[0], one.description ?? '']);
  return each.every(([value]) => typeof value === 'string') ? each : [];
}

function* enumerations(name, schema) {
  const values = valuesOf(schema);
  if (values.length > 1) yield [name, schema.description, values];
  for (const [member, inner] of Object.entries(schema.properties ?? {})) yield* enumerations(`${name}.${member}`, inner);
}

const { components } = await (await fetch('openapi.json')).json();
const found = Object.entries(components.schemas).flatMap(([name, schema]) => [...enumerations(name, schema)]);
document.getElementById('codes').append(...found.map(([name, description, values]) => el('section', {}, el('h3', {}, el('code', {}, name)), description && el('p', {}, description), el('ul', {}, values.map(([value, about]) => el('li', {}, el('code', {}, value), about && ` – ${about}`))))));
