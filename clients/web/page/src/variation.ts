// Variations of a style: which one, how far, whether it changes slowly, and whether each performer has
// its own.
import { paced, type App } from './app.js';
import { h } from './dom.js';
import { section, slider } from './widgets.js';

const MOST = 99;
const HELD_MS = 1500; // as sliders: what the daemon reports may be a second old

/** Another number than `now`, of 1 to 99. */
export function thrown(now: number, random: () => number = Math.random): number {
  if (now < 1 || now > MOST) return 1 + Math.floor(random() * MOST);
  const next = 1 + Math.floor(random() * (MOST - 1));
  return next >= now ? next + 1 : next;
}

export function variation(app: App): HTMLElement {
  let touched_ms = -Infinity;
  const number = h('input', { type: 'number', name: 'vary', min: '0', max: String(MOST), step: '1', value: '0', 'aria-label': 'Number of the variation; 0: as it is' });
  const send = (vary: number) => {
    touched_ms = performance.now();
    number.value = String(vary);
    void app.set({ vary }, vary === 0 ? 'no variation' : `variation ${vary}`);
  };
  number.addEventListener('change', () => {
    const vary = Number(number.value);
    if (number.value === '' || !Number.isInteger(vary) || vary < 0 || vary > MOST) {
      app.onMessage(`a variation is a whole number of 0 to ${MOST}; 0: as it is`, true);
      touched_ms = -Infinity;
      return app.changed();
    }
    send(vary);
  });
  number.addEventListener('input', () => (touched_ms = performance.now()));
  const dice = h('button', { className: 'dice', title: 'Another variation (N)', 'aria-label': 'Another variation', 'data-vary': 'dice',
    onclick: () => send(thrown(Number(number.value))) }, '⚄');
  const plain = h('button', { 'data-vary': 'none', title: 'The style itself', onclick: () => send(0) }, 'As it is');
  const each = h('input', { type: 'checkbox', name: 'vary_each' });
  each.addEventListener('change', () => {
    touched_ms = performance.now();
    void app.set({ varyEach: each.checked }, each.checked ? 'each performer its own variation' : 'one variation for all');
  });
  const amount = slider('Amount', { min: 0, max: 1.5, step: 0.01 }, (value) => `${Math.round(100 * value)} %`,
    paced((value: number) => app.set({ varyAmount: value }, `variation at ${Math.round(100 * value)} %`, 'vary amount')));
  const drift = slider('Drift', { min: 0, max: 60, step: 1 }, (value) => (value === 0 ? 'off' : `${value} s`),
    paced((value: number) => app.set({ driftS: value }, value === 0 ? 'no drift' : `drift, ${value} s from one to the next`, 'drift')));
  drift.element.title = 'The variation changes slowly: seconds from one to the next';
  const box = section('Variation',
    h('div', { className: 'vary' }, dice, number, plain,
      h('label', { title: "Shifted by each performer's name" }, each, ' each its own')),
    h('div', { className: 'twin' }, amount.element, drift.element));
  box.classList.add('variation');
  app.watch(() => {
    const look = app.entry()?.look;
    box.hidden = look?.vary === undefined; // for a daemon that has none
    if (!look || box.hidden) return;
    if (performance.now() - touched_ms > HELD_MS) {
      number.value = String(look.vary ?? 0);
      each.checked = look.varyEach ?? false;
    }
    plain.setAttribute('aria-pressed', String((look.vary ?? 0) === 0 && !look.varyEach && !look.driftS));
    amount.show(look.varyAmount ?? 1);
    drift.show(look.driftS ?? 0);
  });
  return box;
}
