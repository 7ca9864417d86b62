// One performer alone, for OBS: no panels, no floor, only the avatar, or the styled body without one.
// Problems are shown until the first frame was drawn; after that only while a pointer moves, so that they are
// not on air.
import type { PerformerStats, StyledClient } from 'styled-client';

import { Avatar } from './avatar.js';
import { h, setText } from './dom.js';
import { keep, keptFile } from './kept.js';
import type { Alone } from './links.js';
import { Stage } from './stage.js';

const SAID_MS = 5000;
const QUIET_MS = 1500; // after the start, which takes some time
const READ_MS = 10000; // from the first frame on, for a user without an avatar; the body is visible
                       // then
const LISTED = 6; // names

export function solo(client: StyledClient, wish: Alone): { element: HTMLElement; stage: Stage } {
  const stage = new Stage(client, { alone: true, props: wish.props ?? false });
  stage.framing = wish.framing;
  if (wish.mirror) stage.canvas.classList.add('mirrored');
  const note = h('p', { className: 'note', role: 'status', hidden: true });
  const file = h('input', { type: 'file', accept: '.vrm', hidden: true });
  let fault = '', timer = 0;
  let seeking = wish.avatar !== ''; // whether it is stored here is not known yet
  let here: PerformerStats[] | undefined; // as last reported by the daemon
  let avatar: Avatar | undefined;

  const amiss = () => {
    const { linkState: link, daemonState: daemon } = client;
    if (link.kind === 'refused') return link.reason;
    if (link.kind !== 'open') return `styleweb at ${location.host} does not answer.`;
    if (!daemon.up) return daemon.reason || 'The daemon does not answer.';
    return absent() || fault || (stage.flat ? 'Without WebGL in this browser, the body is drawn as lines, and no avatar is drawn.' : '');
  };
  const absent = () => {
    const entry = here?.find(({ performer }) => performer === stage.selected);
    if (!here || entry?.live) return '';
    if (entry) return `${stage.selected} is silent.`;
    if (!stage.selected) return 'Nobody performs.';
    const names = here.filter(({ live }) => live).map(({ performer }) => performer).sort();
    const listed = names.slice(0, LISTED).join(', ') + (names.length > LISTED ? ` and ${names.length - LISTED} more` : '');
    return `no performer ${stage.selected} here; ${listed ? `here are: ${listed}` : 'nobody is'}`;
  };
  const say = () => {
    setText(note, amiss() || (avatar ? '' : 'Click to choose a .vrm, or drop one.'));
    note.hidden = note.textContent === '';
    clearTimeout(timer);
    timer = window.setTimeout(() => (note.hidden = true), SAID_MS);
  };
  // Until the first frame it is shown without a pointer, too; afterwards never again.
  let first_ms: number | undefined;
  const opened_ms = performance.now();
  const watching = window.setInterval(() => {
    const now_ms = performance.now();
    if (!first_ms && client.arrived(stage.selected) > 0) first_ms = now_ms;
    const over = first_ms !== undefined && ((!fault && !seeking) || avatar !== undefined || now_ms - first_ms > READ_MS);
    if (over) clearInterval(watching);
    if (now_ms - opened_ms < QUIET_MS) return;
    setText(note, over ? '' : first_ms ? fault : amiss());
    note.hidden = note.textContent === '';
  }, 250);
  const show = (name: string) => {
    if (name === stage.selected) return;
    stage.performers.get(stage.selected)?.takeOff(); // the performer leaves, the avatar stays
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
    // Stored under the name in the link, so that the next start finds it.
    if (!fault) await keep(new File([chosen], wish.avatar || chosen.name)).catch(() => (fault = 'This browser does not store it.'));
    say();
  };
  const find = async () => {
    const kept = await keptFile(wish.avatar).catch(() => undefined);
    if (kept) return wear(kept);
    fault = `avatar ${wish.avatar} is not on this browser: click to choose it, or drop it here`;
  };

  document.body.dataset.view = 'avatar';
  // A dark scheme would give the page a dark background of the browser's own.
  document.querySelector('meta[name=color-scheme]')?.setAttribute('content', 'normal');
  document.documentElement.style.colorScheme = 'normal';
  document.documentElement.style.background = document.body.style.background = wish.background;
  document.title = `Styled: ${wish.performer || 'avatar'}`;

  if (wish.performer) show(wish.performer);
  client.on('stats', ({ performers }) => {
    here = performers;
    if (wish.performer) return;
    const live = performers.filter((one) => one.live).map(({ performer }) => performer).sort();
    if (!live.includes(stage.selected) && live[0]) show(live[0]);
  });
  client.subscribeStats();
  if (wish.avatar) void find().finally(() => (seeking = false));
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
