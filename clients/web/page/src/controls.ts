// The right-hand side: styles, strength, mix pad, transition, body parts, presets.
import { BodyPart, Root } from 'styled-client';

import { paced, type App } from './app.js';
import type { Cards } from './cards.js';
import { clamp, h, svg } from './dom.js';
import { variation } from './variation.js';
import { section, slider } from './widgets.js';

/** Mixes two styles: horizontally their proportion, vertically the strength. */
function mixPad(app: App): HTMLElement {
  const pick = (label: string) => h('select', { 'aria-label': label });
  const a = pick('first style of the mix'), b = pick('second style of the mix');
  const dot = h('div', { className: 'dot' });
  const pad = h('div', {
    className: 'pad', tabIndex: 0, role: 'application',
    'aria-label': 'Mix pad: left and right mix, up and down strength',
  }, h('span', { className: 'up' }, 'strong'), h('span', { className: 'down' }, 'subtle'), dot);
  let x = 0.5, y = 1 / 1.5; // strength 1
  const paint = () => {
    pad.dataset.knob = y > 0.86 ? 'up' : y < 0.14 ? 'down' : ''; // a word is not shown under it
    dot.style.left = `${100 * x}%`;
    dot.style.top = `${100 * (1 - y)}%`;
  };
  const send = paced(async () => {
    if (a.value === b.value) return app.onMessage('the two styles of the mix are the same', true);
    const mix = [{ style: a.value, weight: 1 - x }, { style: b.value, weight: x }];
    await app.set({ mix: mix.filter(({ weight }) => weight > 0.001), strength: 1.5 * y },
      `${a.value} ${Math.round(100 * (1 - x))}%, ${b.value} ${Math.round(100 * x)}%`, 'mix');
  });
  const move = (nextX: number, nextY: number) => {
    x = clamp(nextX, 0, 1);
    y = clamp(nextY, 0, 1);
    paint();
    send(undefined);
  };
  const drag = (event: PointerEvent) => {
    const box = pad.getBoundingClientRect();
    move((event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height);
  };
  pad.addEventListener('pointerdown', (event) => {
    pad.setPointerCapture(event.pointerId);
    drag(event);
  });
  pad.addEventListener('pointermove', (event) => {
    if (pad.hasPointerCapture(event.pointerId)) drag(event);
  });
  pad.addEventListener('keydown', (event) => {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step) return;
    event.preventDefault();
    event.stopPropagation();
    move(x + 0.05 * step[0]!, y + 0.05 * step[1]!);
  });
  for (const select of [a, b]) select.addEventListener('change', () => send(undefined));
  let shown = '';
  app.watch(() => {
    const names = app.styles();
    const words = new Map(names.map((name) => [name, app.weakness(name) ? `${name} (weak)` : name]));
    const now = [...words.values()].join();
    if (now === shown) return;
    shown = now;
    const chosen = [a.value, b.value];
    for (const select of [a, b]) select.replaceChildren(...names.map((name) => h('option', { value: name, title: app.weakness(name) ?? '' }, words.get(name))));
    a.value = names.includes(chosen[0]!) ? chosen[0]! : names[0] ?? '';
    b.value = names.includes(chosen[1]!) ? chosen[1]! : names[1] ?? '';
  });
  paint();
  return h('div', { className: 'mix' }, pad, h('div', { className: 'pair' }, a, b));
}

const PARTS: [BodyPart, string, string][] = [
  [BodyPart.HEAD, 'head', 'M30 3a8 9 0 0 1 0 18a8 9 0 0 1 0-18ZM26 21h8v4h-8Z'],
  [BodyPart.TORSO, 'torso', 'M19 27h22l-2 20 2 12H19l2-12Z'],
  [BodyPart.RIGHT_ARM, 'right arm', 'M17 27l-6 3-4 19-2 15 4 1 5-16 4-14Z'],
  [BodyPart.LEFT_ARM, 'left arm', 'M43 27l6 3 4 19 2 15-4 1-5-16-4-14Z'],
  [BodyPart.RIGHT_LEG, 'right leg', 'M19 61h10l-1 20-1 20h-6l-1-20Z'],
  [BodyPart.LEFT_LEG, 'left leg', 'M31 61h10l-1 20-1 20h-6l-1-20Z'],
];

/** The parts of the body that are styled; a click toggles one. */
function bodyParts(app: App): HTMLElement {
  const all = PARTS.map(([part]) => part);
  let on = new Set(all);
  let touched_ms = -Infinity;
  const shapes = new Map<BodyPart, SVGElement>();
  const paint = () => {
    for (const [part, shape] of shapes) shape.setAttribute('aria-pressed', String(on.has(part)));
  };
  const toggle = (part: BodyPart) => {
    const next = new Set(on);
    if (!next.delete(part)) next.add(part);
    if (next.size === 0) return app.onMessage('at least one part has to be styled; 0 strength styles none', true);
    on = next;
    touched_ms = performance.now();
    paint();
    void app.set({ parts: on.size === all.length ? [BodyPart.ALL] : [...on] }, 'body parts');
  };
  const figure = svg('svg', { viewBox: '0 0 60 104', class: 'parts' },
    ...PARTS.map(([part, name, path]) => {
      const shape = svg('path', { d: path, tabindex: '0', role: 'button', 'aria-label': name, 'data-part': name });
      const title = svg('title', {});
      title.textContent = name;
      shape.append(title);
      shape.addEventListener('click', () => toggle(part));
      shape.addEventListener('keydown', (event) => {
        if (event.key !== 'Enter' && event.key !== ' ') return;
        event.preventDefault();
        event.stopPropagation();
        toggle(part);
      });
      shapes.set(part, shape);
      return shape;
    }));
  app.watch(() => {
    const parts = app.entry()?.look?.parts ?? [];
    if (performance.now() - touched_ms < 1500) return;
    on = new Set(parts.length === 0 || parts.includes(BodyPart.ALL) ? all : parts);
    paint();
  });
  paint();
  return h('div', { className: 'partbox' }, figure);
}

const ROOTS: [Root, string, string][] = [
  [Root.FOLLOW, 'Follow', "The body stays at the performer's place"],
  [Root.STRIDE, 'Stride', 'The body walks and runs at the speed of the style'],
];

/** The place of the styled body on the floor. */
function rootSwitch(app: App): HTMLElement {
  const box = h('div', { className: 'switch', role: 'group', 'aria-label': 'Path over the floor' });
  for (const [root, label, title] of ROOTS) {
    box.append(h('button', {
      'data-root': label.toLowerCase(), title, onclick: () => void app.set({ root }, label.toLowerCase()),
    }, label));
  }
  app.watch(() => {
    const now = app.entry()?.look?.root ?? Root.FOLLOW;
    ROOTS.forEach(([root], i) => box.children[i]!.setAttribute('aria-pressed', String(root === now)));
  });
  return box;
}

/** Warns about styles that are set with strength 0, and offers to change that. */
function unseen(app: App): HTMLElement {
  const box = h('div', { className: 'unseen', role: 'status', hidden: true }, h('span', {}, 'Strength is 0: no style is visible.'),
    h('button', { 'data-strength': '1', onclick: () => void app.set({ strength: 1 }, 'strength 100 %') }, 'Set to 100 %'));
  app.watch(() => {
    const shown = app.performers().filter(({ performer }) => app.everyone || performer === app.selected);
    box.hidden = !shown.some(({ look }) => look?.strength === 0 && look.mix.some(({ weight }) => weight > 0));
  });
  return box;
}

const SHORT = matchMedia('(max-height: 800px) and (min-width: 1200px)'); // style.css has the same

export function controls(app: App, cards: Cards, cues: HTMLElement, byHand: HTMLElement): HTMLElement {
  const percent = (value: number) => `${Math.round(100 * value)} %`;
  const strength = slider('Strength', { min: 0, max: 1.5, step: 0.01 }, percent,
    paced((value: number) => app.set({ strength: value }, `strength ${percent(value)}`, 'strength')));
  const transition = slider('Transition', { min: 0, max: 5000, step: 50 }, (ms) => `${(ms / 1000).toFixed(2)} s`,
    (ms) => (app.transition_ms = ms));
  transition.show(app.transition_ms);
  const who = h('div', { className: 'switch', role: 'group', 'aria-label': 'Selected performer' });
  for (const [everyone, label] of [[false, 'Selected'], [true, 'Everyone']] as const) {
    who.append(h('button', {
      'data-who': String(everyone),
      onclick: () => {
        app.everyone = everyone;
        app.changed();
      },
    }, label));
  }
  const presets = h('div', { className: 'chips' });
  const bypass = h('button', { onclick: () => void app.clear(), title: 'Bypass (B)' }, 'Bypass');
  const pin = h('button', { title: 'Nothing changes this performer until it is released: no cue, no other user', onclick: () => void app.pin(!app.entry()?.pinned) }, 'Pin');
  const reset = h('button', { onclick: () => void app.reset(), title: 'The style forgets the last seconds and starts again' }, 'Reset');
  const calibrate = h('button', {
    onclick: () => void app.calibrateNeutral(),
    title: 'The performer stands, then walks, in their own way for 5 s; without it, it is learned while they move',
  }, 'Learn walk');
  const mirror = h('button', {
    'data-mirror': '', title: 'Left and right are exchanged, for all who receive this performer (the link for OBS can turn the picture alone)',
    onclick: () => {
      const mirrored = !(app.entry()?.look?.mirror ?? false);
      void app.set({ mirror: mirrored }, mirrored ? 'mirrored' : 'not mirrored');
    },
  }, 'Mirror');
  const idle = h('button', {
    'data-idle': '', title: 'The body breathes, sways and blinks by itself, also while the rig is silent',
    onclick: () => {
      const on = (app.entry()?.look?.idle ?? 0) === 0;
      void app.set({ idle: on ? 1 : 0 }, on ? 'moves by itself' : 'moves only with the rig');
    },
  }, 'Breathe');
  const presetSection = section('Presets', presets);
  presetSection.classList.add('presets');
  let shown = '';
  app.watch(() => {
    const entry = app.entry();
    calibrate.hidden = entry?.neutral === undefined;
    if (entry?.look) strength.show(entry.look.strength ?? 1);
    pin.setAttribute('aria-pressed', String(entry?.pinned ?? false));
    mirror.hidden = entry?.look?.mirror === undefined; // for a daemon that has none
    mirror.setAttribute('aria-pressed', String(entry?.look?.mirror ?? false));
    idle.hidden = entry?.look?.idle === undefined;
    idle.setAttribute('aria-pressed', String((entry?.look?.idle ?? 0) > 0));
    bypass.setAttribute('aria-pressed', String(entry?.look !== undefined && (entry.look.mix.length === 0 || entry.look.strength === 0)));
    for (const button of who.children) {
      button.setAttribute('aria-pressed', String(button.getAttribute('data-who') === String(app.everyone)));
    }
    const names = (app.list?.presets ?? []).map(({ name }) => name);
    presetSection.hidden = names.length === 0;
    if (names.join() !== shown) {
      shown = names.join();
      presets.replaceChildren(...names.map((name) =>
        h('button', { 'data-preset': name, onclick: () => void app.preset(name) }, name.replaceAll('_', ' '))));
    }
    for (const chip of presets.children) {
      chip.setAttribute('aria-pressed', String(chip.getAttribute('data-preset') === entry?.look?.preset));
    }
  });
  const none = unseen(app);
  const style = section('Style', who, none, cards.element);
  style.classList.add('stylebox');
  style.firstElementChild!.append(cards.toggle);
  const two = h('div', { className: 'two' }, section('Mix', mixPad(app)), section('Body', bodyParts(app)));
  const watching = h('p', { className: 'hint watching' }, 'For watching only: this gateway refuses changes.');
  const controls = h('fieldset', { className: 'whole' }, style,
    h('section', { className: 'force' }, h('div', { className: 'twin' }, strength.element, transition.element), rootSwitch(app),
      h('div', { className: 'row acts' }, bypass, pin, mirror, idle, reset, calibrate)),
    byHand, variation(app), cues, presetSection, two);
  app.watch(() => {
    watching.hidden = !app.watchOnly;
    const rows = SHORT.matches && !cues.hidden ? 1 : 2;
    style.style.minHeight = `${(SHORT.matches ? 84 : 100) + none.offsetHeight + cards.least(rows)}px`;
    controls.disabled = two.inert = app.watchOnly;
  });
  return h('aside', { className: 'panel right' }, watching, controls);
}
