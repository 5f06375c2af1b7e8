// The page: its views, the units and the theme, the link that holds the state, and the notice while the service is away.

import { redrawCharts } from './charts.js';
import { ContactView } from './contact/view.js';
import { debounced, el } from './dom.js';
import { Field } from './fields.js';
import { fragmentOf, readFragment } from './link.js';
import { PartView } from './part/view.js';
import { PathView } from './path/view.js';
import { onReachable } from './service.js';
import { startTooltips } from './tooltip.js';
import { setUnits, units } from './units.js';

const THEMES = [['auto', 'Auto'], ['light', 'Light'], ['dark', 'Dark']];
const writeLink = debounced(200, () => history.replaceState(null, '', fragmentOf(active.name, units(), active.values())));

const views = [new ContactView(writeLink), new PartView(writeLink), new PathView(writeLink)];
let active = views[0];

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
    // A browser that stores nothing forgets the choice.
  }
};

function useTheme(theme) {
  if (theme === 'auto') document.documentElement.removeAttribute('data-theme');
  else document.documentElement.dataset.theme = theme;
}

function useUnits(name) {
  setUnits(name);
  unitField.set(name);
  for (const view of views) view.show();
}

const unitField = new Field({ name: 'units', label: 'Units', help: 'Units of the page. The service itself works in millimetres.', choices: [['mm', 'mm'], ['inch', 'inch']], segmented: true, value: 'mm' }, ({ value }) => {
  remember('units', value);
  useUnits(value);
  writeLink();
});
const themeField = new Field({ name: 'theme', label: 'Theme', help: 'Colours of the page.', choices: THEMES, value: 'auto' }, ({ value }) => {
  remember('theme', value);
  useTheme(value);
  for (const view of views) view.show();
  redrawCharts();
});

const tabs = views.map((view) => document.getElementById(`tab-${view.name}`));

function activate(view, focus) {
  active = view;
  views.forEach((each, i) => {
    each.element.hidden = each !== view;
    tabs[i].setAttribute('aria-selected', each === view);
    tabs[i].tabIndex = each === view ? 0 : -1;
  });
  if (focus) tabs[views.indexOf(view)].focus();
  document.title = `${tabs[views.indexOf(view)].textContent} – scallopd workbench`;
  if (view.name === 'contact') view.ask();
}

function readLink() {
  const { view: name, units: stated, values } = readFragment(location.hash);
  const view = views.find((each) => each.name === name) ?? views[0];
  if (values) view.take(values);
  useUnits(stated ?? remembered('units') ?? 'mm');
  activate(view, false);
}

tabs.forEach((tab, i) => {
  tab.addEventListener('click', () => {
    activate(views[i], false);
    writeLink();
  });
  tab.addEventListener('keydown', ({ key }) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[key];
    if (!step) return;
    activate(views[(i + step + views.length) % views.length], true);
    writeLink();
  });
  views[i].element.setAttribute('role', 'tabpanel');
  views[i].element.setAttribute('aria-labelledby', tab.id);
});

document.getElementById('settings').append(unitField.element, themeField.element);
document.getElementById('views').replaceChildren(...views.map(({ element }) => element));
startTooltips();

const away = document.getElementById('away');
onReachable((reachable) => {
  away.hidden = reachable;
  if (reachable) for (const view of views) if (view === active && view.name !== 'part') view.ask();
});

themeField.set(remembered('theme') ?? 'auto');
useTheme(themeField.value);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redrawCharts);
addEventListener('hashchange', readLink);
readLink();
views[1].start();
