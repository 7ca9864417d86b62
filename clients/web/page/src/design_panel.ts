// "Style by hand": the sliders of the selected performer's own style, which moves while they do.
import type { SliderInfo } from 'styled-client';

import type { App } from './app.js';
import { Live, choicesOf, designOf, groupsOf, handName, sameSliders, stepOf, wordsOf, type Design } from './design.js';
import { h, setText } from './dom.js';
import type { Examples } from './examples.js';
import type { Figure } from './cards.js';
import { nameFault, proposedName, replacedBy } from './names.js';
import { slider, type Slider } from './widgets.js';

const HELD_MS = 1500; // what the daemon reports may be older than what was sent

// The part that a step changes.
interface State {
  design: Design;
  choice: string; // what it begins with
  start: Design; // to which Reset leads
}

// A performer's style by hand on this page.
interface Hand extends State {
  undone: State[]; // for Redo
  touched_ms: number;
  saved: { name: string; design: Design } | undefined;
}

export interface DesignPanel {
  element: HTMLElement;
  /** Repeats the last step that was undone; false: no step was. */
  redo(): boolean;
}

/** `figure`: shows a small moving figure of a style in a canvas, or of none. */
export function designPanel(app: App, examples: Examples, figure: Figure): DesignPanel {
  const hands = new Map<string, Hand>();
  const knobs = new Map<string, Slider>();
  let shown = ''; // the sliders that were built
  let listed = app.list;

  const handOf = (performer: string): Hand | undefined => {
    const known = hands.get(performer);
    if (known || !app.list || !performer) return known;
    const own = `style ${handName(performer)}`, neutral = app.list.styles.find((style) => style.neutral);
    const choice = app.info(handName(performer))?.made ? own : `style ${neutral?.name}`;
    const design = designOf(app.list, choice);
    if (!design) return undefined;
    const hand: Hand = { design, choice, start: design, undone: [], touched_ms: -Infinity, saved: undefined };
    hands.set(performer, hand);
    return hand;
  };
  const worn = (performer: string): boolean => {
    const mix = app.looks(performer).get(performer)?.look.mix.filter(({ weight }) => weight > 0) ?? [];
    return mix.length === 1 && mix[0]!.style === handName(performer);
  };

  const live = new Live<Design>(async (performer, { from, sliders }) => {
    const dressed = worn(performer);
    try {
      await app.client.design(performer, {
        from: from === handName(performer) ? '' : from, sliders, ...(dressed ? {} : { transitionMs: app.transition_ms }) });
    } catch (error) {
      app.report(error, 'style by hand');
    }
    const hand = hands.get(performer);
    if (hand) hand.touched_ms = performance.now();
    if (!dressed) await app.fetchLooks().catch(() => {});
  }, () => void app.refresh());

  // Shows and sends a design. Undo leads back to the present one, and to the look before it.
  const change = (performer: string, to: Partial<Hand> & { design: Design }, what: string, gesture = '') => {
    const hand = handOf(performer)!;
    const { design, choice, start } = hand;
    const looks = worn(performer) ? undefined : app.looks(performer);
    Object.assign(hand, to, { touched_ms: performance.now() });
    app.undo.push({
      what,
      back: async () => {
        live.drop(performer);
        await live.settled();
        const undone = [...hand.undone, { design: hand.design, choice: hand.choice, start: hand.start }];
        Object.assign(hand, { design, choice, start, undone, touched_ms: performance.now() });
        if (looks) await app.restore(looks);
        else live.put(performer, design);
        paint();
      },
    }, gesture && `${performer} ${gesture}`);
    live.put(performer, hand.design);
    app.changed();
  };

  const move = (info: SliderInfo, value: number) => {
    const hand = handOf(app.selected);
    if (!hand) return app.onMessage('no performer is present yet', true);
    const design = { ...hand.design, sliders: { ...hand.design.sliders, [info.name]: value } };
    change(app.selected, { design, undone: [] }, `${info.title} ${wordsOf(info.unit, value).read}`, info.name);
  };
  const redo = (): boolean => {
    const hand = handOf(app.selected);
    const next = hand?.undone.at(-1);
    if (!hand || !next || element.hidden || app.watchOnly) return false;
    change(app.selected, { ...next, undone: hand.undone.slice(0, -1) }, 'style by hand');
    return true;
  };

  const begin = h('select', { 'aria-label': 'Start from', name: 'design_from' });
  begin.addEventListener('change', () => {
    const design = app.list && designOf(app.list, begin.value);
    if (!design || !handOf(app.selected)) return paint();
    change(app.selected, { design, choice: begin.value, start: design, undone: [] }, begin.selectedOptions[0]!.text);
  });
  const undoButton = h('button', { type: 'button', 'data-design': 'undo', title: 'Ctrl+Z', onclick: () => void app.undoLast() }, 'Undo');
  const redoButton = h('button', { type: 'button', 'data-design': 'redo', title: 'Ctrl+Shift+Z', onclick: () => redo() }, 'Redo');
  const reset = h('button', {
    type: 'button', 'data-design': 'reset', title: 'All sliders as at the start', onclick: () => {
      const hand = handOf(app.selected);
      if (hand) change(app.selected, { design: hand.start, undone: [] }, 'sliders reset');
    },
  }, 'Reset');
  const canvas = h('canvas', { width: 168, height: 132, 'aria-hidden': 'true' });
  const whose = h('p', { className: 'hint' });
  const sliders = h('div', { className: 'knobs' });
  const saving = saveForm(app, async (name) => {
    const performer = app.selected, hand = handOf(performer);
    if (!hand) return;
    const { design } = hand;
    await live.settled();
    if (await examples.design(name, design)) hand.saved = { name, design };
  });
  const share = h('button', {
    type: 'button', 'data-design': 'share', title: 'Saves its file; drop it on another page to import it', onclick: async () => {
      await live.settled();
      const { saved, design } = handOf(app.selected)!;
      const same = saved && saved.design.from === design.from && sameSliders(saved.design, design) && app.info(saved.name);
      await examples.save(same ? saved.name : handName(app.selected));
    },
  }, 'Share');
  const body = h('div', { className: 'design' },
    h('div', { className: 'start' }, canvas, h('div', {}, whose, h('label', {}, 'Start from', begin),
      h('div', { className: 'row' }, undoButton, redoButton, reset))),
    sliders, h('div', { className: 'keep' }, saving.element, share));
  const fold = h('details', { className: 'byhand' }, h('summary', {}, h('h2', {}, 'Style by hand')), body);
  fold.addEventListener('toggle', () => paint());
  const element = h('section', { hidden: true, className: 'handbox' }, fold);

  const build = (infos: SliderInfo[]) => {
    const text = JSON.stringify(infos.map(({ name, title, group, unit, least, most, what }) => [name, title, group, unit, least, most, what]));
    if (text === shown) return;
    shown = text;
    knobs.clear();
    sliders.replaceChildren(...[...groupsOf(infos)].map(([group, members]) => h('fieldset', { className: 'group' }, h('legend', {}, group),
      h('div', { className: 'twin' }, ...members.map((info) => {
        const knob = slider(info.title, { min: info.least, max: info.most, step: stepOf(info) }, (value) => wordsOf(info.unit, value).read,
          (value) => move(info, value), { heard: (value) => wordsOf(info.unit, value).heard, what: info.what });
        knob.element.dataset.slider = info.name;
        knobs.set(info.name, knob);
        return knob.element;
      })))));
  };

  // Another user, or OSC, has moved the sliders of the performer's style.
  const follow = (performer: string, hand: Hand) => {
    if (!app.list || performance.now() - hand.touched_ms < HELD_MS || !app.info(handName(performer))) return;
    const choice = `style ${handName(performer)}`, now = designOf(app.list, choice)!;
    if (sameSliders(now, hand.design)) return;
    Object.assign(hand, { design: now, choice, start: now, undone: [] });
  };
  let offered = '';
  const offer = () => {
    const groups = app.list ? choicesOf(app.list) : [];
    const text = JSON.stringify(groups);
    if (text === offered) return;
    offered = text;
    const options = (choices: { value: string; words: string }[]) => choices.map(({ value, words }) => h('option', { value }, words));
    begin.replaceChildren(...groups.flatMap(({ group, choices }): HTMLElement[] =>
      group ? [h('optgroup', { label: group }, ...options(choices))] : options(choices)));
  };

  const paint = () => {
    const infos = app.list?.sliders ?? [];
    element.hidden = infos.length === 0 || app.watchOnly;
    if (element.hidden || !fold.open) return figure.show(undefined);
    build(infos);
    offer();
    const performer = app.selected, hand = handOf(performer);
    body.inert = !hand || !app.client.daemonState.up;
    setText(whose, performer ? `Moves ${performer}. Less or more of it: Strength.` : 'No performer is present yet.');
    if (!hand) return figure.show(undefined);
    if (app.list !== listed) {
      listed = app.list;
      follow(performer, hand);
    }
    begin.value = hand.choice;
    for (const [name, knob] of knobs) knob.put(hand.design.sliders[name] ?? 0);
    undoButton.disabled = app.undo.size === 0;
    undoButton.title = app.undo.last ? `Undo: ${app.undo.last.what} (Ctrl+Z)` : 'Nothing to undo (Ctrl+Z)';
    redoButton.disabled = hand.undone.length === 0;
    reset.disabled = hand.design.from === hand.start.from && sameSliders(hand.design, hand.start);
    share.disabled = !app.info(handName(performer));
    saving.paint();
    figure.show(handName(performer), canvas);
  };
  app.watch(paint);
  paint();
  return { element, redo };
}

// The name under which a style is kept.
function saveForm(app: App, save: (name: string) => Promise<void>): { element: HTMLElement; paint(): void } {
  const name = h('input', { type: 'text', name: 'design_name', maxLength: 40, spellcheck: false, autocomplete: 'off',
    placeholder: 'Name', 'aria-label': 'Name under which the style is saved' });
  const remark = h('p', { className: 'hint', role: 'status' });
  const check = (): string => {
    const taken = app.taken(), given = name.value.trim(), fault = given ? nameFault(given, taken) : '';
    const replaced = replacedBy(given, taken);
    setText(remark, fault || (replaced ? `Replaces ${replaced}. Undo brings it back.` : ''));
    remark.classList.toggle('bad', fault !== '');
    return fault;
  };
  name.addEventListener('input', check);
  const element = h('form', {
    className: 'saving', noValidate: true,
    onsubmit: (event: Event) => {
      event.preventDefault();
      if (name.value.trim() === '') name.value = proposedName('by-hand', app.taken());
      if (check()) return name.focus();
      void save(name.value.trim());
    },
    onkeydown: (event: KeyboardEvent) => {
      if (event.key !== 'Escape') return;
      event.stopPropagation(); // Esc here leaves the field instead of Panic
      name.blur();
    },
  }, name, h('button', { 'data-design': 'save' }, 'Save'), remark);
  return { element, paint: () => void check() };
}
