// The way of a performer's frames as a picture, and their fates with the causes: the daemon's sentences, each with its
// number of frames.
import { Fate, type FrameFate, type Stats } from 'styled-client';

import type { App } from './app.js';
import { chainOf, type State } from './chain.js';
import { type Dialog, dialog } from './dialog.js';
import { h, setText } from './dom.js';

const FRAMES = 600; // five seconds at 120 Hz
const EVERY_MS = 500;

export interface Cause {
  text: string;
  count: number;
}

/** The causes of frames that need an explanation, the most frequent first, and the number of those that need none. */
export function causes(frames: Pick<FrameFate, 'cause' | 'isBody' | 'fate'>[]): { well: number; causes: Cause[] } {
  const counts = new Map<string, number>();
  let well = 0;
  for (const { cause, isBody, fate } of frames) {
    if (cause) counts.set(cause, (counts.get(cause) ?? 0) + 1);
    else if (!isBody && fate === Fate.STYLED) ++well;
  }
  return { well, causes: [...counts].map(([text, count]) => ({ text, count })).sort((a, b) => b.count - a.count) };
}

const SIGNS: Record<State, [sign: string, words: string]> = { ok: ['✓', 'in order'], warn: ['!', 'look here'], bad: ['×', 'broken'], off: ['–', 'not in use'] };

// From the rig to this page, drawn once a second.
function picture(app: App): HTMLElement {
  const row = h('ol', { className: 'chain', 'aria-label': 'From the rig to the reader' });
  let before: Stats | undefined, counted = 0, of = '';
  app.client.on('stats', (now) => {
    const performer = app.selected, count = performer ? app.client.arrived(performer, 'rig') : 0;
    const links = chainOf(now, before, performer, performer === of ? count - counted : undefined);
    [before, counted, of] = [now, count, performer];
    while (row.children.length < links.length) row.append(h('li', {}, h('i', {}), h('b', {}), h('span', {})));
    links.forEach(({ name, state, text }, i) => {
      const [sign, title, words] = row.children[i]!.children;
      (row.children[i] as HTMLElement).dataset.state = state;
      setText(sign!, SIGNS[state][0]);
      sign!.setAttribute('role', 'img');
      sign!.setAttribute('aria-label', SIGNS[state][1]);
      setText(title!, name);
      setText(words!, text);
    });
  });
  return row;
}

/** The dialog that shows the fates of the selected performer's frames. While open it is updated twice a second. */
export function why(app: App): Dialog {
  const newest = h('p', {}), list = h('ul', {});
  const box = dialog('From the rig to the reader', 'why', picture(app), h('h3', {}, 'Fate of the frames'), newest, list);
  const fill = async () => {
    const performer = app.selected;
    if (!performer) return setText(newest, 'No performer is present yet.');
    const frames = await app.client.explain(performer, { last: FRAMES });
    const found = causes(frames);
    newest.textContent = `${performer}: ${frames.at(-1)?.text ?? 'no frame arrived yet.'}`;
    const lines = found.causes.map(({ text, count }) => `${count} of the last ${frames.length}: ${text}`);
    if (found.well > 0) lines.push(`${found.well} of the last ${frames.length} were published without anything to report.`);
    list.replaceChildren(...lines.map((line) => h('li', {}, line)));
  };
  const turn = () => {
    if (!box.element.open) return;
    fill().catch((error: Error) => (newest.textContent = error.message))
      .finally(() => setTimeout(turn, EVERY_MS));
  };
  const show = () => {
    box.show();
    turn();
  };
  return { ...box, show };
}
