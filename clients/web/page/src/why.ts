// What became of a performer's frames, and why: the daemon's own sentences, with how often each holds.
import { Fate, type FrameFate } from 'styled-client';

import type { App } from './app.js';
import { type Dialog, dialog } from './dialog.js';
import { h } from './dom.js';

const FRAMES = 600; // five seconds at 120 Hz
const EVERY_MS = 500;

export interface Cause {
  text: string;
  count: number;
}

/** The causes of frames that were not simply published, the most frequent first, and how many were. */
export function causes(frames: Pick<FrameFate, 'cause' | 'isBody' | 'fate'>[]): { well: number; causes: Cause[] } {
  const counts = new Map<string, number>();
  let well = 0;
  for (const { cause, isBody, fate } of frames) {
    if (cause) counts.set(cause, (counts.get(cause) ?? 0) + 1);
    else if (!isBody && fate === Fate.STYLED) ++well;
  }
  return { well, causes: [...counts].map(([text, count]) => ({ text, count })).sort((a, b) => b.count - a.count) };
}

/** The dialog that tells it of the selected performer, anew twice a second while it is open. */
export function why(app: App): Dialog {
  const newest = h('p', {}), list = h('ul', {});
  const box = dialog('What became of the frames', 'why', newest, list);
  const fill = async () => {
    const performer = app.selected;
    const frames = await app.client.explain(performer, { last: FRAMES });
    const found = causes(frames);
    newest.textContent = `${performer}: ${frames.at(-1)?.text ?? 'nothing came yet.'}`;
    const lines = found.causes.map(({ text, count }) => `${count} of the last ${frames.length}: ${text}`);
    if (found.well > 0) lines.push(`${found.well} of the last ${frames.length} were published, and there is nothing to say of them.`);
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
