// The top bar, messages, and the current problem.
import { CommercialUse, type Stats } from 'styled-client';

import type { App } from './app.js';
import { h, setText } from './dom.js';
import { findings, strays } from './findings.js';
import { licencesDialog } from './licences.js';
import type { Stage } from './stage.js';

const MESSAGE_MS = 4000;
const UNDO_MS = 10000;
const READ_MS = 60; // reading time per letter

interface Trouble {
  kind: 'ok' | 'wait' | 'bad'; // selects the colour of the light
  title: string;
  text: string;
  sources?: boolean; // facts about the sources help
  token?: boolean; // the right one helps
}

/** The current problem. The title is empty while all is well. */
function trouble(app: App): Trouble {
  const { linkState: link, daemonState: daemon } = app.client;
  if (link.kind === 'refused') {
    const text = link.status === 401
      ? `${link.reason}. Type the token, or open this page as ${location.origin}/#token=...` : link.reason;
    return { kind: 'bad', title: 'The gateway refuses this page', text, token: link.status === 401 };
  }
  if (link.kind !== 'open') {
    return { kind: 'bad', title: 'The gateway is away',
             text: `styleweb at ${location.host} does not answer. Retrying.` };
  }
  if (!daemon.up) {
    return { kind: 'bad', title: 'The daemon is away', text: `${daemon.reason || 'styled does not answer'}. Waiting for it.` };
  }
  if (app.performers().length === 0) {
    return { kind: 'wait', title: 'The stage is empty',
             text: 'The daemon runs, but no rig sends. Point one at it, or start stylesim.', sources: true };
  }
  if (app.live().length === 0) {
    return { kind: 'wait', title: 'The rig is silent', text: 'No frames arrive. stylectl doctor shows more.', sources: true };
  }
  return { kind: 'ok', title: '', text: '' };
}

export function banner(app: App): HTMLElement {
  const title = h('b', {}), text = h('span', {}), list = h('ul', {});
  const given = h('input', { type: 'password', name: 'token', required: true, autocomplete: 'off', 'aria-label': 'Token of this gateway' });
  const token = h('form', {
    className: 'token', hidden: true, onsubmit: (event: Event) => {
      event.preventDefault();
      sessionStorage.setItem('token', given.value.trim());
      location.reload();
    },
  }, given, h('button', { className: 'go' }, 'Open'));
  const box = h('div', { className: 'banner', role: 'status' }, title, text, token, list);
  let stats: Stats | undefined, found: string[] = [], lost: string[] = [];
  app.client.on('stats', (now) => {
    found = app.live().length === 0 ? findings(now, stats) : [];
    lost = strays(now);
    stats = now;
    update();
  });
  const update = () => {
    const state = trouble(app);
    const now = state.kind === 'ok' && lost.length > 0 ? { kind: 'note', title: 'Arrives, and reaches no performer', text: '', sources: true, token: false } : state;
    box.hidden = now.kind === 'ok';
    box.dataset.kind = now.kind;
    setText(title, now.title);
    setText(text, now.text);
    token.hidden = now.token !== true;
    const lines = state.kind === 'ok' ? lost : now.sources ? found : [];
    list.hidden = lines.length === 0;
    // A screen reader is notified of changes, not once a second.
    const words = (line: string) => line.replace(/\d+ datagrams/, '');
    if (lines.map(words).join() !== [...list.children].map((line) => words(line.textContent!)).join()) {
      list.replaceChildren(...lines.map((line) => h('li', {}, line)));
    }
    document.body.dataset.state = state.kind;
  };
  app.watch(update);
  update();
  return box;
}

/** The last message. A step that it offers to undo is offered for ten seconds. */
export function toast(app: App): HTMLElement {
  const words = h('span', { role: 'log' });
  const undo = h('button', { className: 'small', 'data-toast': 'undo', hidden: true, title: 'Ctrl+Z', onclick: () => void app.undoLast() }, 'Undo');
  const box = h('div', { className: 'toast' }, words, undo);
  let timer = 0;
  const hide = () => {
    box.classList.remove('shown');
    undo.hidden = true;
  };
  app.onMessage = (text, bad, step) => {
    setText(words, text);
    box.classList.toggle('bad', bad);
    box.classList.add('shown');
    undo.hidden = step === undefined;
    undo.setAttribute('aria-label', `Undo: ${step?.what}`);
    clearTimeout(timer);
    timer = window.setTimeout(hide, step ? UNDO_MS : Math.max(MESSAGE_MS, READ_MS * text.length));
  };
  app.client.on('complaint', (text, unknown) => {
    // A performer that the daemon lists is not misspelt, only silent; the list shows that already.
    if (unknown && app.performers().some(({ performer }) => performer === unknown)) return;
    app.onMessage(text, true);
  });
  return box;
}

/** `version`: the same button as in the bar, for the end of a page that is too narrow for it there. */
export function topBar(app: App, stage: Stage, help: () => void): { element: HTMLElement; version: HTMLElement } {
  const state = h('span', {}), fps = h('span', { className: 'fps' }), licences = licencesDialog(app);
  const about = [0, 1].map(() =>
    h('button', { className: 'quiet about', title: 'Licences: what may be used commercially', 'aria-haspopup': 'dialog', onclick: licences.show }));
  const light = h('span', { className: 'state' }, h('i', {}), state);
  let known = 0n;
  const learn = async () => {
    const status = await app.client.status();
    known = status.epoch;
    const commercial = status.terms.every(({ commercialUse }) => commercialUse !== CommercialUse.NO);
    const words = `styled ${status.version} · ${status.weights.split('/').pop()}${commercial ? '' : ' · not for commercial use'}`;
    for (const one of about) setText(one, words);
  };
  const undo = h('button', { className: 'quiet undo', 'aria-label': 'Undo', onclick: () => void app.undoLast() },
    h('b', {}, '↶'), h('span', {}, 'Undo'));
  const panic = h('button', { className: 'panic', onclick: () => void app.panic(), title: 'All performers to bypass (Esc)' }, 'Panic', h('kbd', {}, 'Esc'));
  app.watch(() => {
    undo.disabled = app.watchOnly || app.undo.size === 0;
    undo.title = app.undo.last ? `Undo: ${app.undo.last.what} (Ctrl+Z)` : 'Nothing to undo (Ctrl+Z)';
    panic.disabled = app.watchOnly;
    const now = trouble(app);
    state.replaceChildren(...(now.kind === 'ok' ? [`live · ${app.live().length}`, h('span', { className: 'extra' }, ' performing')] : [now.title.toLowerCase()]));
    if (app.client.daemonState.up && app.stats && app.stats.epoch !== known) {
      known = app.stats.epoch;
      learn().catch(() => (known = 0n));
    }
  });
  setInterval(() => setText(fps, `${stage.fps.toFixed(0)} fps`), 1000);
  const element = h('header', {},
    h('h1', {}, h('img', { src: '/icon.svg', alt: '' }), h('span', {}, 'Styled')), light, about[0],
    h('span', { className: 'space' }), fps,
    h('button', { className: 'quiet keys', onclick: help, title: 'Keys (?)', 'aria-label': 'Keys', 'aria-haspopup': 'dialog' }, '?'),
    undo, panic, licences.element);
  return { element, version: h('section', { className: 'version' }, about[1]) };
}
