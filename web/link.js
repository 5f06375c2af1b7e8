// The page's state as a link: "#contact?units=mm&diameter_mm=10&...". Numbers are in the service's units whatever the page shows.

/** The fragment of a view and its values; structured values are written as JSON. */
export function fragmentOf(view, unitsInUse, values) {
  const query = new URLSearchParams({ units: unitsInUse });
  for (const [name, value] of Object.entries(values)) query.set(name, typeof value === 'object' ? JSON.stringify(value) : String(value));
  return `#${view}?${query}`;
}

/** {view, units, values} of a fragment. Texts that can be parsed as numbers become numbers. */
export function readFragment(fragment) {
  const [view, query = ''] = fragment.replace(/^#/, '').split('?');
  const values = {};
  let unitsInUse;
  for (const [name, text] of new URLSearchParams(query)) {
    if (name === 'units') unitsInUse = text;
    else values[name] = text === '' ? undefined : valueOf(text);
  }
  return { view, units: unitsInUse, values: query ? values : null };
}

function valueOf(text) {
  if (/^[[{]/.test(text)) {
    try {
      return JSON.parse(text);
    } catch {
      return text;
    }
  }
  return text !== '' && text.trim() === text && Number.isFinite(Number(text)) ? Number(text) : text;
}
