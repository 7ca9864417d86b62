// One performer alone, for OBS: no panels, no floor, nothing but the avatar, or the styled body
// without one. What is amiss is said only while a pointer moves, so that it is not on air.
import type { StyledClient } from 'styled-client';

import { Avatar } from './avatar.js';
import { h, setText } from './dom.js';
import { keep, keptFile } from './kept.js';
import type { Alone } from './links.js';
import { Stage } from './stage.js';

const SAID_MS = 5000;

export function solo(client: StyledClient, wish: Alone): { element: HTMLElement; stage: Stage } {
  const stage = new Stage(client, { alone: true, props: wish.props ?? false });
  const note = h('p', { className: 'note', role: 'status', hidden: true });
  const file = h('input', { type: 'file', accept: '.vrm', hidden: true });
  let fault = '', timer = 0;
  let avatar: Avatar | undefined;

  const words = () => {
    const { linkState: link, daemonState: daemon } = client;
    if (link.kind === 'refused') return link.reason;
    if (link.kind !== 'open') return `styleweb at ${location.host} does not answer.`;
    if (!daemon.up) return daemon.reason || 'The daemon does not answer.';
    if (!stage.selected) return 'Nobody performs.';
    return fault || (avatar ? '' : 'Click to choose a .vrm, or drop one.');
  };
  const say = () => {
    setText(note, words());
    note.hidden = note.textContent === '';
    clearTimeout(timer);
    timer = window.setTimeout(() => (note.hidden = true), SAID_MS);
  };
  const show = (name: string) => {
    if (name === stage.selected) return;
    stage.performers.get(stage.selected)?.takeOff(); // the performer goes, the avatar stays
    stage.selected = name;
    stage.setPerformers(name ? [name] : []);
    stage.performers.get(name)?.setAvatar(avatar);
  };
  const wear = async (chosen: File) => {
    try {
      avatar = await Avatar.load(chosen);
      fault = '';
    } catch (error) {
      fault = (error as Error).message;
      return;
    }
    stage.performers.get(stage.selected)?.setAvatar(avatar);
  };
  const choose = async (chosen: File) => {
    await wear(chosen);
    // Kept under the name that the link asks for, so that the next start finds it.
    if (!fault) await keep(new File([chosen], wish.avatar || chosen.name)).catch(() => (fault = 'This browser does not keep it.'));
    say();
  };
  const find = async () => {
    const kept = await keptFile(wish.avatar).catch(() => undefined);
    if (kept) return wear(kept);
    fault = `${wish.avatar} is not kept in this browser: click to choose it, or drop it.`;
  };

  document.body.dataset.view = 'avatar';
  // A dark scheme would give the page a dark ground of the browser's own.
  document.querySelector('meta[name=color-scheme]')?.setAttribute('content', 'normal');
  document.documentElement.style.colorScheme = 'normal';
  document.documentElement.style.background = document.body.style.background = wish.background;
  document.title = `Styled: ${wish.performer || 'avatar'}`;

  if (wish.performer) show(wish.performer);
  else {
    client.on('stats', ({ performers }) => {
      const live = performers.filter((one) => one.live).map(({ performer }) => performer).sort();
      if (!live.includes(stage.selected) && live[0]) show(live[0]);
    });
    client.subscribeStats();
  }
  if (wish.avatar) void find();
  addEventListener('pointermove', say);
  stage.canvas.addEventListener('click', () => file.click());
  file.addEventListener('change', () => file.files?.[0] && void choose(file.files[0]));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    const [dropped] = event.dataTransfer?.files ?? [];
    if (dropped) void choose(dropped);
  });
  return { element: h('main', { className: 'alone' }, stage.element, note, file), stage };
}
