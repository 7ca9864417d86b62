// The left-hand side: the performers, their views and their avatars.
import type { PerformerStats } from 'styled-client';

import type { App } from './app.js';
import { Avatar } from './avatar.js';
import type { Dialog } from './dialog.js';
import { h, setText } from './dom.js';
import { neutralWords } from './findings.js';
import { keep, keptFile, lastWorn, noteWorn } from './kept.js';
import { kindOf } from './names.js';
import type { Stage } from './stage.js';
import { why } from './why.js';

function list(app: App, explain: Dialog): HTMLElement {
  const box = h('div', { className: 'roster', role: 'listbox', 'aria-label': 'Performers' });
  const rows = new Map<string, { row: HTMLElement; rate: HTMLElement; words: HTMLElement; parts: HTMLElement; wrong: HTMLElement }>();
  const empty = h('p', { className: 'hint' }, 'No performer is present yet. Point a rig at the daemon, or start stylesim.');
  // Number of statistics in a row: a part of the first one may be from before the style was set.
  const hardly = new Map<string, number>();
  app.client.on('stats', ({ performers }) => {
    for (const entry of performers) {
      const now = entry.live && entry.hardlyStyled;
      hardly.set(entry.performer, now ? (hardly.get(entry.performer) ?? 0) + 1 : 0);
    }
    app.changed();
  });
  app.watch(() => {
    // Performers that were only named follow those that have been present, which may otherwise be
    // out of sight.
    const came = ({ live, received }: PerformerStats) => live || received > 0n;
    const performers = app.performers().sort((a, b) => Number(came(b)) - Number(came(a)));
    const names = performers.map(({ performer }) => performer);
    if (names.join() !== [...rows.keys()].join()) {
      rows.clear();
      for (const name of names) {
        const rate = h('span', { className: 'rate' }), words = h('span', { className: 'words' }), parts = h('span', { className: 'words layers' }), wrong = h('span', { className: 'words wrong' });
        const row = h('button', { role: 'option', 'data-performer': name, onclick: () => (app.selected === name ? explain.show() : app.select(name)) },
          h('i', {}), h('b', {}, name), rate, words, parts, wrong);
        rows.set(name, { row, rate, words, parts, wrong });
      }
      box.replaceChildren(...[...rows.values()].map(({ row }) => row));
    }
    empty.hidden = names.length > 0;
    for (const entry of performers) {
      const { row, rate, words, parts, wrong } = rows.get(entry.performer)!;
      row.setAttribute('aria-selected', String(entry.performer === app.selected));
      row.classList.toggle('live', entry.live);
      const also = entry.layers.map(({ part, source, live }) => `${part}: ${source} (${live ? 'live' : 'silent'})`).join(', ');
      row.title = entry.performer === app.selected ? `${also ? `${also}. ` : ''}Click: the fate of the frames, and why` : also;
      setText(rate, entry.live ? `${entry.rateHz.toFixed(0)} Hz` : 'silent');
      const set = (entry.look?.mix ?? []).filter(({ weight }) => weight > 0).map(({ style }) => style).join(' + ');
      setText(words, (entry.look?.preset || set || 'bypass') + (entry.pinned ? ' · pinned' : '') + neutralWords(entry));
      layers(parts, entry);
      const nothing = entry.live && entry.hardlyStyled && (hardly.get(entry.performer) ?? 0) >= 2;
      setText(wrong, app.client.daemonState.up ? [entry.warning, nothing ? 'hardly styled now' : ''].filter((text) => text).join('; ') : '');
      wrong.hidden = wrong.textContent === '';
    }
  });
  return h('section', { className: 'grow' }, h('div', { className: 'who' }, h('h2', {}, 'Performers'), box, empty),
    h('div', { className: 'whose' },
      h('button', { className: 'quiet', 'data-why': '', onclick: () => explain.show() }, 'Why? From rig to reader'), ownStyle(app)));
}

// The parts that other sources provide for a performer, such as a phone the face, and the own
// style.
function layers(line: HTMLElement, { layers, look }: PerformerStats): void {
  const given = [...(look?.inputStyle ? [{ text: `moves as: ${look.inputStyle}`, live: true }] : []),
    ...layers.map(({ source, part, live }) => ({ text: `${part}: ${source}${live ? '' : ', silent'}`, live }))];
  line.hidden = given.length === 0;
  const now = JSON.stringify(given);
  if (line.dataset.shown === now) return;
  line.dataset.shown = now;
  line.replaceChildren(...given.map(({ text, live }) => h('span', { className: live ? 'live' : 'silent' }, text)));
}

/** The selected performer's own style, which is removed first. */
function ownStyle(app: App): HTMLElement {
  const choice = h('select', { name: 'own', 'aria-label': 'Own style' });
  choice.addEventListener('change', () => void app.setOwnStyle(choice.value));
  const box = h('label', { className: 'own', title: "The performer's own style: it is removed before another is applied" },
    h('span', {}, 'Own style'), choice);
  let shown = '';
  app.watch(() => {
    const entry = app.entry();
    box.hidden = !entry?.look || app.list === undefined || app.watchOnly;
    const own = entry?.look?.inputStyle ?? '';
    // A style that these weights do not have stays in the list, so that it is visible.
    const names = [...new Set([...app.styles(), ...(own ? [own] : [])])];
    if (names.join() !== shown) {
      shown = names.join();
      choice.replaceChildren(h('option', { value: '' }, 'none'), ...names.map((name) => h('option', { value: name }, name)));
    }
    if (document.activeElement !== choice) choice.value = own;
  });
  return box;
}

export interface Looks {
  element: HTMLElement;
  toggle(what: 'overlay' | 'trails' | 'contacts'): void;
}

function looks(stage: Stage): Looks {
  const side = h('button', { onclick: () => overlay(false) }, 'Beside');
  const over = h('button', { onclick: () => overlay(true) }, 'Overlaid');
  const trails = h('button', { onclick: () => toggle('trails'), title: 'T' }, 'Foot trails');
  const contacts = h('button', { onclick: () => toggle('contacts'), title: 'C' }, 'Contacts');
  const paint = () => {
    side.setAttribute('aria-pressed', String(!stage.view.overlay));
    over.setAttribute('aria-pressed', String(stage.view.overlay));
    trails.setAttribute('aria-pressed', String(stage.view.trails));
    contacts.setAttribute('aria-pressed', String(stage.view.contacts));
  };
  const overlay = (on: boolean) => {
    stage.view.overlay = on;
    stage.place();
    paint();
  };
  const toggle = (what: 'overlay' | 'trails' | 'contacts') => {
    if (what === 'overlay') return overlay(!stage.view.overlay);
    stage.view[what] = !stage.view[what];
    paint();
  };
  paint();
  return {
    element: h('section', {}, h('h2', {}, 'View'),
      h('div', { className: 'switch', title: 'V' }, side, over),
      h('div', { className: 'row' }, trails, contacts)),
    toggle,
  };
}

interface Wardrobe {
  element: HTMLElement;
  /** Restores the last avatars of new performers. */
  dress(names: string[]): void;
}

function wardrobe(app: App, stage: Stage, take: (files: File[]) => boolean, share: () => void): Wardrobe {
  const file = h('input', { type: 'file', accept: '.vrm', hidden: true });
  const label = h('span', {});
  const zone = h('button', { className: 'drop', onclick: () => file.click() }, label);
  const off = h('button', { className: 'off', title: 'Remove it', 'aria-label': 'Remove the avatar' }, '×');
  const link = h('button', { className: 'links', onclick: share, title: 'Links for OBS and for a phone' }, 'OBS, phone …');
  const put = async (name: string, chosen: File) => {
    const wearer = stage.performers.get(name);
    const avatar = await Avatar.load(chosen);
    wearer?.setAvatar(avatar);
    return avatar.lostPictures;
  };
  const wear = async (chosen: File) => {
    const name = app.selected;
    if (!stage.performers.has(name)) return app.onMessage('no performer is present to wear it', true);
    app.onMessage(`loading ${chosen.name} …`, false);
    try {
      const lost = await put(name, chosen);
      const kept = await keep(chosen).then(() => true, () => false);
      noteWorn(name, kept ? chosen.name : '');
      app.onMessage(`${name} wears ${chosen.name}` + (lost === 0 ? '' : lost === 1
        ? '; one of its textures could not be loaded' : `; ${lost} of its textures could not be loaded`) +
        (kept ? '' : '; this browser does not store it'), lost > 0 || !kept);
    } catch (error) {
      app.onMessage((error as Error).message, true);
    }
    app.changed();
  };
  const dressed = new Set<string>();
  const dress = (names: string[]) => {
    for (const name of dressed) if (!names.includes(name)) dressed.delete(name); // may return
    for (const name of names) {
      if (dressed.has(name)) continue;
      dressed.add(name);
      const worn = lastWorn(name);
      if (!worn) continue;
      void keptFile(worn).then(async (kept) => {
        if (kept && !stage.performers.get(name)?.avatar) await put(name, kept);
        app.changed();
      }).catch(() => noteWorn(name, '')); // no longer stored, or no longer an avatar
    }
  };
  off.addEventListener('click', () => {
    stage.performers.get(app.selected)?.setAvatar(undefined);
    noteWorn(app.selected, '');
    app.changed();
  });
  file.addEventListener('change', () => {
    if (file.files?.[0]) void wear(file.files[0]);
    file.value = '';
  });
  const hover = (on: boolean) => document.body.classList.toggle('dropping', on);
  addEventListener('dragover', (event) => {
    event.preventDefault();
    hover(true);
  });
  addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) hover(false);
  });
  addEventListener('drop', (event) => {
    event.preventDefault();
    hover(false);
    const dropped = [...(event.dataTransfer?.files ?? [])];
    const avatar = dropped.find(({ name }) => kindOf(name) === 'avatar');
    if (avatar) void wear(avatar);
    else if (dropped[0] && !take(dropped)) {
      app.onMessage(`${dropped[0].name}: expected .vrm, an avatar; .bvh, .glb or .vrma, an example of a style; or the .json of a style`, true);
    }
  });
  app.watch(() => {
    const name = stage.performers.get(app.selected)?.avatar?.name;
    setText(label, name ?? 'Drop a .vrm here');
    zone.classList.toggle('worn', name !== undefined);
    off.hidden = name === undefined;
  });
  return {
    element: h('section', {}, h('h2', {}, 'Avatar'), h('div', { className: 'wardrobe' }, zone, off, file), link),
    dress,
  };
}

/** `examples`: its panel, which also accepts dropped files that are not avatars. `share`: shows the links. */
export function roster(
  app: App, stage: Stage, record: HTMLElement, examples: { element: HTMLElement; take(files: File[]): boolean }, share: () => void,
): { element: HTMLElement; looks: Looks; dress(names: string[]): void } {
  const view = looks(stage);
  const explain = why(app);
  const clothes = wardrobe(app, stage, examples.take, share);
  return {
    element: h('aside', { className: 'panel left' }, list(app, explain), explain.element, examples.element, record, view.element, clothes.element),
    looks: view,
    dress: clothes.dress,
  };
}
