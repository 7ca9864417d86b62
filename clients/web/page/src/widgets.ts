// Widgets that several panels use.
import { h, setText } from './dom.js';

export function section(title: string, ...children: (Node | undefined)[]): HTMLElement {
  return h('section', {}, h('h2', {}, title), ...children.filter((c) => c !== undefined));
}

export interface Slider {
  element: HTMLElement;
  show(value: number): void;
}

export function slider(name: string, range: { min: number; max: number; step: number }, words: (v: number) => string,
                input: (value: number) => void): Slider {
  const value = h('output', {});
  const knob = h('input', { type: 'range', ...range, 'aria-label': name, name: name.toLowerCase() });
  let held_ms = -Infinity;
  const paint = () => {
    setText(value, words(Number(knob.value)));
    const part = (Number(knob.value) - range.min) / (range.max - range.min);
    knob.style.setProperty('--part', `${(100 * part).toFixed(1)}%`);
  };
  knob.addEventListener('input', () => {
    held_ms = performance.now();
    paint();
    input(Number(knob.value));
  });
  paint();
  return {
    element: h('label', { className: 'slider' }, h('span', {}, name), value, knob),
    show(next) {
      // The daemon's value is up to a second old: while a knob is in use, the knob's own value is
      // shown.
      if (performance.now() - held_ms < 1500 || Math.abs(Number(knob.value) - next) < range.step / 2) return;
      knob.value = String(next);
      paint();
    },
  };
}
