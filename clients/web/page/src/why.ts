// The fates of a performer's frames and their causes: the daemon's sentences, each with its number of frames.
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

/** The dialog that shows the fates of the selected performer's frames. While open it is updated twice a second. */
export function why(app: App): Dialog {
  const newest = h('p', {}), list = h('ul', {});
  const box = dialog('Fate of the frames', 'why', newest, list);
  const fill = async () => {
    const performer = app.selected;
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
