// Builders of HTML and SVG elements. Styles are never set by attribute: the page's security policy forbids it.

const SVG = 'http://www.w3.org/2000/svg';

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** An HTML element; members of `attributes` that begin with "on" are event listeners. */
export function el(name, attributes, ...children) {
  return fill(document.createElement(name), attributes, children);
}

/** An SVG element. */
export function svg(name, attributes, ...children) {
  return fill(document.createElementNS(SVG, name), attributes, children);
}

/** A label that opens the hidden file input `id`, with the pointer and with the keyboard. */
export function fileButton(id, ...children) {
  const open = (event) => {
    if (event.key !== 'Enter' && event.key !== ' ') return;
    event.preventDefault();
    document.getElementById(id).click();
  };
  return el('label', { for: id, class: 'button', tabindex: '0', role: 'button', onkeydown: open }, ...children);
}

/** Calls `draw(width)` once the element has a width and whenever it changes. */
export function onWidth(element, draw) {
  let last = 0;
  new ResizeObserver(([entry]) => {
    const width = Math.round(entry.contentRect.width);
    if (width > 0 && width !== last) draw((last = width));
  }).observe(element);
}

/** Runs the last of a burst of calls, `delay` milliseconds after it. */
export function debounced(delay, run) {
  let timer;
  return (...args) => {
    clearTimeout(timer);
    timer = setTimeout(() => run(...args), delay);
  };
}
