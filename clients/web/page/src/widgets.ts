// Widgets that several panels use.
import { h, setText } from './dom.js';

export function section(title: string, ...children: (Node | undefined)[]): HTMLElement {
  return h('section', {}, h('h2', {}, title), ...children.filter((c) => c !== undefined));
}

export interface Slider {
  element: HTMLElement;
  /** Shows what the daemon reports, unless the knob is in use. */
  show(value: number): void;
  /** Shows a value in any case. */
  put(value: number): void;
}

/** `heard`: the value for a screen reader; `what`: a sentence that describes the knob. */
export function slider(name: string, range: { min: number; max: number; step: number }, words: (v: number) => string,
                input: (value: number) => void, { heard = words, what = '' }: { heard?: (v: number) => string; what?: string } = {}): Slider {
  const value = h('output', {});
  const knob = h('input', { type: 'range', ...range, 'aria-label': name, name: name.toLowerCase(), title: what });
  let held_ms = -Infinity;
  const paint = () => {
    setText(value, words(Number(knob.value)));
    knob.setAttribute('aria-valuetext', heard(Number(knob.value)));
    const part = (Number(knob.value) - range.min) / (range.max - range.min);
    knob.style.setProperty('--part', `${(100 * part).toFixed(1)}%`);
  };
  knob.addEventListener('input', () => {
    held_ms = performance.now();
    paint();
    input(Number(knob.value));
  });
  paint();
  const put = (next: number) => {
    if (Math.abs(Number(knob.value) - next) < range.step / 2) return;
    knob.value = String(next);
    paint();
  };
  return {
    element: h('label', { className: 'slider', title: what }, h('span', {}, name), value, knob),
    put,
    show(next) {
      // The daemon's value is up to a second old: while a knob is in use, the knob's own value is
      // shown.
      if (performance.now() - held_ms >= 1500) put(next);
    },
  };
}
