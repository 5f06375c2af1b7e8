// One tooltip for the page: shown for an element with `data-help` under the pointer or with the focus, hidden by Escape.

import { el } from './dom.js';

const bubble = el('div', { id: 'tooltip', role: 'tooltip', hidden: true });
let shownFor = null;

function show(owner) {
  if (shownFor === owner) return;
  hide();
  shownFor = owner;
  bubble.textContent = owner.dataset.help;
  bubble.hidden = false;
  owner.setAttribute('aria-describedby', bubble.id);
  const box = owner.getBoundingClientRect();
  const { width, height } = bubble.getBoundingClientRect();
  const below = box.bottom + 6 + height < innerHeight;
  bubble.style.left = `${Math.max(8, Math.min(box.left, innerWidth - width - 8))}px`;
  bubble.style.top = `${below ? box.bottom + 6 : Math.max(4, box.top - height - 6)}px`;
}

function hide() {
  shownFor?.removeAttribute('aria-describedby');
  shownFor = null;
  bubble.hidden = true;
}

/** Starts to listen; the page calls it once. */
export function startTooltips() {
  document.body.append(bubble);
  const ownerOf = (event) => (event.target instanceof Element ? event.target.closest('[data-help]') : null);
  document.addEventListener('pointerover', (event) => {
    const owner = ownerOf(event);
    if (owner) show(owner);
    else if (shownFor && !shownFor.matches(':focus-visible')) hide();
  });
  document.addEventListener('focusin', (event) => {
    const owner = ownerOf(event);
    if (owner?.matches(':focus-visible')) show(owner);
    else hide();
  });
  document.addEventListener('focusout', hide);
  document.addEventListener('scroll', hide, { passive: true, capture: true });
  document.addEventListener('keydown', (event) => event.key === 'Escape' && hide());
}
