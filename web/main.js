// The page: its views, the units and the theme, the link that holds the state, and the notice while the service cannot be reached.

import { redrawCharts } from './charts.js';
import { ContactView } from './contact/view.js';
import { debounced } from './dom.js';
import { acceptDrops } from './drop.js';
import { Field } from './fields.js';
import { fragmentOf, readFragment } from './link.js';
import { Unreachable, get, onReachable } from './service.js';
import { startTooltips } from './tooltip.js';
import { setUnits, units } from './units.js';

const THEMES = [['auto', 'Auto'], ['light', 'Light'], ['dark', 'Dark']];
const NAMES = ['contact', 'part', 'path'];
const link = () => fragmentOf(active.name, units(), active.state());
const writeLink = debounced(200, () => active && history.replaceState(null, '', link()));
/** Makes the present state a step of the browser's history, to which Back returns. */
const keepState = () => {
  if (active && location.hash !== link()) history.pushState(null, '', link());
};

// Views other than the first are made when they are first shown.
const makers = {
  contact: () => new ContactView(writeLink),
  part: async () => new (await import('./part/view.js')).PartView(writeLink, showPath, keepState),
  path: async () => new (await import('./path/view.js')).PathView(writeLink, keepState),
};
const made = new Map();
let active = null;

function viewOf(name) {
  if (!made.has(name)) {
    const making = make(name);
    // A view whose files could not be loaded is tried again.
    making.catch(() => made.delete(name));
    made.set(name, making);
  }
  return made.get(name);
}

async function make(name) {
  const view = await makers[name]();
  view.element.hidden = true;
  view.element.setAttribute('role', 'tabpanel');
  view.element.setAttribute('aria-labelledby', `tab-${name}`);
  document.getElementById('views').append(view.element);
  views.push(view);
  view.useUnits(units() === 'inch');
  view.start?.();
  return view;
}

const views = [];

const remembered = (name) => {
  try {
    return localStorage.getItem(name);
  } catch {
    return null;
  }
};
const remember = (name, value) => {
  try {
    localStorage.setItem(name, value);
  } catch {
    // The choice is lost if the browser stores nothing.
  }
};

function useTheme(theme) {
  if (theme === 'auto') document.documentElement.removeAttribute('data-theme');
  else document.documentElement.dataset.theme = theme;
}

function useUnits(name) {
  setUnits(name);
  unitField.set(name);
  for (const view of views) {
    view.useUnits(units() === 'inch');
    view.show();
  }
}

const unitField = new Field({ name: 'units', label: 'Units', help: 'Units of the page. The service itself works in millimetres.', choices: [['mm', 'mm'], ['inch', 'inch']], segmented: true, value: 'mm' }, ({ value }) => {
  remember('units', value);
  useUnits(value);
  if (active.name !== 'part') active.ask();
  writeLink();
});
const themeField = new Field({ name: 'theme', label: 'Theme', help: 'Colours of the page.', choices: THEMES, value: 'auto' }, ({ value }) => {
  remember('theme', value);
  useTheme(value);
  for (const view of views) view.show();
  redrawCharts();
});

const nonsense = document.getElementById('nonsense');
const tabs = NAMES.map((name) => document.getElementById(`tab-${name}`));

function showTab(name, focus) {
  tabs.forEach((tab, i) => {
    tab.setAttribute('aria-selected', NAMES[i] === name);
    tab.tabIndex = NAMES[i] === name ? 0 : -1;
    if (NAMES[i] !== name) return;
    if (focus) tab.focus();
    document.title = `${tab.textContent} – scallopd workbench`;
  });
}

let wanted = null;

/** Shows a view, with the values of a link where there are some. */
async function activate(name, { focus = false, values = null, isFirst = true } = {}) {
  wanted = name;
  showTab(name, focus);
  const view = await viewOf(name);
  if (wanted !== name) return;
  active = view;
  for (const each of views) each.element.hidden = each !== view;
  nonsense.hidden = true;
  if (values) {
    const unknown = view.take(values);
    nonsense.hidden = unknown.length === 0;
    nonsense.textContent = `The link has parts that this page does not know, which are left out: ${unknown.join(', ')}`;
  }
  view.show();
  if (name === 'contact') view.ask();
  if (isFirst) view.begin?.();
}

/** Shows a table of contacts with the values of its cutter, or {check}: a program and its part, in the tool path view. */
async function showPath(content, values) {
  await activate('path', { focus: true });
  const opened = active.open(content, values);
  keepState();
  return opened;
}

async function readLink() {
  const { view: name, units: stated, values } = readFragment(location.hash);
  useUnits(stated ?? remembered('units') ?? 'mm');
  await activate(NAMES.includes(name) ? name : 'contact', { values });
  if (name === '' || NAMES.includes(name)) return;
  nonsense.hidden = false;
  nonsense.textContent = `The link names a view that this page does not have: ${name}`;
}

tabs.forEach((tab, i) => {
  tab.addEventListener('click', () => activate(NAMES[i]).then(keepState));
  tab.addEventListener('keydown', ({ key }) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
    if (step) activate(NAMES[(i + step + NAMES.length) % NAMES.length], { focus: true }).then(keepState);
  });
});

acceptDrops(async (kind, files) => {
  await activate({ library: 'part', surface: active.name === 'path' ? 'path' : 'part' }[kind] ?? 'path', { isFirst: false });
  await active.takeFiles(kind, files);
  keepState();
});

document.getElementById('settings').append(unitField.element, themeField.element);
document.getElementById('views').replaceChildren();
startTooltips();

const away = document.getElementById('away');
onReachable((reachable) => {
  away.hidden = reachable;
  if (!reachable) return;
  for (const view of views) view.start?.();
  if (active && active.name !== 'part') active.ask();
});

themeField.set(remembered('theme') ?? 'auto');
useTheme(themeField.value);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redrawCharts);
addEventListener('hashchange', readLink);
await readLink();
async function showVersion() {
  try {
    const { answer } = await get('v1/about');
    if (answer) document.getElementById('version').textContent = `Version ${answer.version}`;
  } catch (error) {
    if (!(error instanceof Unreachable)) throw error;
  }
}

// Loads the rest of the page, so that it works even if the service stops.
const makeAll = () => setTimeout(() => {
  NAMES.forEach((name) => viewOf(name).catch(() => {}));
  showVersion();
}, 300);
if (document.readyState === 'complete') makeAll();
else addEventListener('load', makeAll);
