// The daemon's cues: GO fires the next one, Back the one before; the last one that was fired here is marked.
import type { CueInfo } from 'styled-client';

import type { App } from './app.js';
import { h, setText } from './dom.js';
import { section } from './widgets.js';

/** Cues in the order of the configuration; those of one name are fired together. */
export interface Cue {
  name: string;
  /** The performers that the cue changes, and its timecode. */
  words: string;
}

export function cuesOf(list: readonly CueInfo[]): Cue[] {
  const byName = new Map<string, string[]>();
  for (const { name, at, performer } of list) {
    const words = byName.get(name) ?? [];
    words.push([performer === '*' ? 'everyone' : performer, at].filter((part) => part).join(' at '));
    byName.set(name, words);
  }
  return [...byName].map(([name, words]) => ({ name, words: words.join(', ') }));
}

/** The name of the cue that GO (step 1) or Back (-1) fires; undefined at the ends of the list. `current`: the last one fired, '' for none. */
export function cueBeside(cues: readonly Cue[], current: string, step: 1 | -1): string | undefined {
  return cues[cues.findIndex(({ name }) => name === current) + step]?.name;
}

export interface CuePanel {
  element: HTMLElement;
  go(): void;
}

export function cuePanel(app: App): CuePanel {
  let cues: Cue[] = [], current = '', shown = '';
  const list = h('div', { className: 'cues', role: 'group', 'aria-label': 'Cues' });
  const fire = async (name: string | undefined) => {
    if (name === undefined || !(await app.cue(name))) return;
    current = name;
    paint();
    for (const row of list.children) if (row.ariaCurrent) row.scrollIntoView({ block: 'nearest' });
  };
  const go = h('button', { className: 'go', 'data-cue-go': '', onclick: () => void fire(cueBeside(cues, current, 1)) }, h('b', {}, 'GO'), h('span', {}), h('kbd', {}, 'G'));
  const back = h('button', { 'data-cue-back': '', onclick: () => void fire(cueBeside(cues, current, -1)) }, 'Back');
  const element = section('Cues', list, h('div', { className: 'cuerow' }, go, back));
  element.classList.add('cuebox');
  const paint = () => {
    cues = cuesOf(app.list?.cues ?? []);
    element.hidden = cues.length === 0;
    const now = JSON.stringify(cues);
    if (now !== shown) {
      shown = now;
      if (!cues.some(({ name }) => name === current)) current = '';
      list.replaceChildren(...cues.map(({ name, words }) => h('button', { 'data-cue': name, title: `Fire ${name}: ${words}`, onclick: () => void fire(name) },
        h('b', {}, name), h('span', {}, words))));
    }
    const next = cueBeside(cues, current, 1), before = cueBeside(cues, current, -1);
    for (const row of list.children) {
      const name = row.getAttribute('data-cue');
      if (name === current) row.setAttribute('aria-current', 'step');
      else row.removeAttribute('aria-current');
      row.classList.toggle('next', name === next);
    }
    go.disabled = next === undefined;
    go.title = next === undefined ? 'The last cue is fired' : `Fire ${next} (G)`;
    setText(go.children[1]!, next ?? 'end');
    back.disabled = before === undefined;
    back.title = before === undefined ? 'No cue before this one' : `Fire ${before} again`;
  };
  app.watch(paint);
  paint();
  return { element, go: () => !element.hidden && !go.disabled && go.click() };
}
