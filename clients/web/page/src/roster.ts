// The left-hand side: the performers, their views and their avatars.
import type { App } from './app.js';
import { Avatar } from './avatar.js';
import { h, setText } from './dom.js';
import { kindOf } from './names.js';
import type { Stage } from './stage.js';

function list(app: App): HTMLElement {
  const box = h('div', { className: 'roster', role: 'listbox', 'aria-label': 'Performers' });
  const rows = new Map<string, { row: HTMLElement; rate: HTMLElement; words: HTMLElement }>();
  const empty = h('p', { className: 'hint' }, 'Nobody is here yet. Point a rig at the daemon, or start stylesim.');
  app.watch(() => {
    const performers = app.performers();
    const names = performers.map(({ performer }) => performer);
    if (names.join() !== [...rows.keys()].join()) {
      rows.clear();
      for (const name of names) {
        const rate = h('span', { className: 'rate' }), words = h('span', { className: 'words' });
        const row = h('button', { role: 'option', 'data-performer': name, onclick: () => app.select(name) },
          h('i', {}), h('b', {}, name), rate, words);
        rows.set(name, { row, rate, words });
      }
      box.replaceChildren(...[...rows.values()].map(({ row }) => row));
    }
    empty.hidden = names.length > 0;
    for (const entry of performers) {
      const { row, rate, words } = rows.get(entry.performer)!;
      row.setAttribute('aria-selected', String(entry.performer === app.selected));
      row.classList.toggle('live', entry.live);
      setText(rate, entry.live ? `${entry.rateHz.toFixed(0)} Hz` : 'silent');
      const set = (entry.look?.mix ?? []).filter(({ weight }) => weight > 0).map(({ style }) => style).join(' + ');
      setText(words, (entry.look?.preset || set || 'bypass') + (entry.pinned ? ' · pinned' : ''));
    }
  });
  return h('section', { className: 'grow' }, h('h2', {}, 'Performers'), box, empty);
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

function wardrobe(app: App, stage: Stage, take: (files: File[]) => boolean): HTMLElement {
  const file = h('input', { type: 'file', accept: '.vrm', hidden: true });
  const label = h('span', {});
  const zone = h('button', { className: 'drop', onclick: () => file.click() }, label);
  const off = h('button', { className: 'off', title: 'Take it off' }, '×');
  const wear = async (chosen: File) => {
    const wearer = stage.performers.get(app.selected);
    if (!wearer) return app.onMessage('nobody is here to wear it', true);
    app.onMessage(`loading ${chosen.name} …`, false);
    try {
      const avatar = await Avatar.load(chosen);
      wearer.setAvatar(avatar);
      const lost = avatar.lostPictures;
      app.onMessage(`${wearer.name} wears ${chosen.name}` + (lost === 0 ? '' : lost === 1
        ? '; one of its textures could not be loaded' : `; ${lost} of its textures could not be loaded`), lost > 0);
    } catch (error) {
      app.onMessage((error as Error).message, true);
    }
    app.changed();
  };
  off.addEventListener('click', () => {
    stage.performers.get(app.selected)?.setAvatar(undefined);
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
  return h('section', {}, h('h2', {}, 'Avatar'), h('div', { className: 'wardrobe' }, zone, off, file));
}

/** `examples`: its panel, and who takes the files that are dropped and no avatar. */
export function roster(
  app: App, stage: Stage, record: HTMLElement, examples: { element: HTMLElement; take(files: File[]): boolean },
): { element: HTMLElement; looks: Looks } {
  const view = looks(stage);
  return {
    element: h('aside', { className: 'panel left' }, list(app), examples.element, record, view.element, wardrobe(app, stage, examples.take)),
    looks: view,
  };
}
