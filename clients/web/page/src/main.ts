import './style.css';

import { StyledClient } from 'styled-client';

import { App } from './app.js';
import { Cards } from './cards.js';
import { controls } from './controls.js';
import { cuePanel } from './cues.js';
import { designPanel } from './design_panel.js';
import { h } from './dom.js';
import { examplePanel } from './example_panel.js';
import { Examples } from './examples.js';
import { keys } from './keys.js';
import { aloneOf, type Alone } from './links.js';
import { StyleMenu } from './menu.js';
import { plots } from './plots.js';
import { recordPanel } from './record.js';
import { roster } from './roster.js';
import { share } from './share.js';
import { solo } from './solo.js';
import { Stage } from './stage.js';
import { banner, toast, topBar } from './status.js';

// A token follows the '#', which browsers do not send to a server; it is stored for this tab.
function token(): string | undefined {
  const given = new URLSearchParams(location.hash.slice(1)).get('token');
  if (given) {
    sessionStorage.setItem('token', given);
    history.replaceState(null, '', location.pathname + location.search);
  }
  return sessionStorage.getItem('token') ?? undefined;
}

// The page with all its panels.
function whole(client: StyledClient, known: string | undefined): object {
  const app = new App(client);
  const stage = new Stage(client);
  const record = recordPanel(app, stage);
  const examples = new Examples(app);
  const menu = new StyleMenu(app, examples);
  const chosen = () => stage.performers.get(app.selected);
  const cards = new Cards(app, () => chosen()?.weights ?? new Map<string, number>(), menu);
  const example = examplePanel(app, examples, cards);
  const links = share(app, stage, known);
  const left = roster(app, stage, record.element, example, links.show);
  const cues = cuePanel(app);
  const byHand = designPanel(app, examples, cards.elsewhere());
  const help = keys(app, stage, left.looks, record, cues, example.cancel, byHand.redo);

  const bar = topBar(app, stage, help.toggle);

  document.getElementById('app')!.append(
    bar.element,
    left.element,
    h('main', {}, stage.element, banner(app), record.badge, example.lesson, toast(app)),
    controls(app, cards, cues.element, byHand.element),
    plots(app, () => chosen()?.missed ?? 0),
    bar.version,
    menu.element,
    help.element,
    links.element,
  );
  stage.onSelect = (name) => app.select(name);
  let shown = '';
  app.watch(() => {
    const names = app.performers().map(({ performer }) => performer);
    const now = `${names.join()}|${app.selected}`;
    if (now === shown) return;
    shown = now;
    stage.selected = app.selected;
    stage.setPerformers(names);
    left.dress(names);
  });
  app.changed();
  return { app, client, stage, cards, recorder: record.recorder };
}

// One performer alone, for OBS.
function alone(client: StyledClient, wish: Alone): object {
  const { element, stage } = solo(client, wish);
  document.getElementById('app')!.append(element);
  return { client, stage };
}

const known = token();
const client = new StyledClient({ url: location.origin, ...(known ? { token: known } : {}) });
const wish = aloneOf(location.search, (text) => CSS.supports('color', text));

// For tests and for the browser's console.
Object.assign(window, { styled: wish ? alone(client, wish) : whole(client, known) });
