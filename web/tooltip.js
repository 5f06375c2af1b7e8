// One tooltip for the page: shown for an element with `data-help` after the pointer rests on it or with the keyboard's focus, hidden by Escape
// and by typing. It never covers the next field: beside the panel, or above.

import { el } from './dom.js';

const bubble = el('div', { id: 'tooltip', role: 'tooltip', hidden: true });
const RESTS_MS = 350;
let shownFor = null;
let resting = null;

function show(owner) {
  if (shownFor === owner) return;
  hide();
  shownFor = owner;
  bubble.textContent = owner.dataset.help;
  bubble.hidden = false;
  owner.setAttribute('aria-describedby', bubble.id);
  const box = owner.getBoundingClientRect();
  const { width, height } = bubble.getBoundingClientRect();
  const panel = owner.closest('.panel')?.getBoundingClientRect();
  const isBeside = panel && panel.right + width + 16 < innerWidth;
  const isBelow = !owner.closest('.field') && box.bottom + 6 + height < innerHeight;
  bubble.style.left = `${isBeside ? panel.right + 6 : Math.max(8, Math.min(box.left, innerWidth - width - 8))}px`;
  bubble.style.top = `${isBeside ? Math.min(box.top, innerHeight - height - 8) : isBelow ? box.bottom + 6 : Math.max(4, box.top - height - 6)}px`;
}

function hide() {
  clearTimeout(resting);
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
    clearTimeout(resting);
    if (owner) resting = setTimeout(() => owner.isConnected && show(owner), RESTS_MS);
    else if (shownFor && !shownFor.matches(':focus-visible')) hide();
  });
  document.addEventListener('focusin', (event) => {
    const owner = ownerOf(event);
    if (owner?.matches(':focus-visible')) show(owner);
    else hide();
  });
  document.addEventListener('focusout', hide);
  document.addEventListener('scroll', hide, { passive: true, capture: true });
  document.addEventListener('input', hide);
  document.addEventListener('keydown', (event) => event.key === 'Escape' && hide());
}
