// The styles as cards: name, key, weight in force, a small moving figure; a menu on made ones.
import type { ListReply, StyleInfo } from 'styled-client';

import type { App } from './app.js';
import { clamp, h, setText } from './dom.js';
import { Figures } from './figures.js';
import { licenceText } from './licences.js';
import type { StyleMenu } from './menu.js';
import { Previews } from './previews.js';

export const STYLE_KEYS = '1234567890';
const LONG = 20; // letters; a longer name of a made style is cut, and complete in its title
const WIDTH = 84, HEIGHT = 66; // of a figure, in pixels of the page
const KEPT = 'styled.figures'; // whether figures are shown, in this browser

interface Card {
  name: string;
  info: string; // the data from which it was built
  box: HTMLElement;
  pick: HTMLButtonElement;
  fill: HTMLElement;
  figure: HTMLElement;
  canvas: HTMLCanvasElement | undefined;
}

/** A figure of one style, in another panel. */
export interface Figure {
  /** Of no style: the canvas is left as it is. */
  show(style: string | undefined, canvas?: HTMLCanvasElement): void;
}

const textOf = (info: StyleInfo, place: number) =>
  JSON.stringify([info.name, info.weak, info.recognized, info.model, info.made, info.source, info.nearest, info.distance, info.varies, info.licence, place < 20 ? place : 20]);

// The values that change without a new card.
const slidersOf = ({ sliders }: StyleInfo) => JSON.stringify(Object.entries(sliders).sort());

function titleOf(app: App, info: StyleInfo, key: string): string {
  const parts = [key ? `${info.name} (${key})` : info.name];
  const weakness = app.weakness(info.name);
  if (weakness) parts.push(weakness);
  if (info.model) parts.push(`network ${info.model}`);
  if (info.source) parts.push(`from ${info.source}`);
  if (info.made && info.nearest) parts.push(`nearest ${info.nearest}, distance ${info.distance.toFixed(2)}`);
  const licence = licenceText(info);
  if (licence) parts.push(licence);
  return parts.join(', ');
}

export class Cards {
  readonly element: HTMLElement;
  /** Shows or hides the figures. */
  readonly toggle: HTMLElement;
  readonly figures = new Figures();
  readonly previews: Previews;
  private readonly grid = h('div', { className: 'styles', role: 'group', 'aria-label': 'Styles' });
  private readonly filter = h('input', {
    type: 'search', className: 'filter', placeholder: 'Find a style', 'aria-label': 'Find a style', spellcheck: false, autocomplete: 'off',
  });
  private readonly count = h('span', { className: 'hint', role: 'status' });
  private readonly cards = new Map<string, Card>();
  private readonly inView = new Set<string>();
  private readonly watcher: IntersectionObserver;
  private moving = localStorage.getItem(KEPT) !== 'off';
  private order = '';
  private listed: ListReply | undefined; // the present content
  private version = '';
  private readonly others = new Map<string, { style: string; canvas: HTMLCanvasElement }>(); // by keys that no style has as name
  private made = 0; // figures elsewhere
  private lit = new Set<string>(); // cards whose fill is not empty

  constructor(private readonly app: App, private readonly inForce: () => Map<string, number>, private readonly menu: StyleMenu) {
    this.previews = new Previews((style) => app.client.preview(style));
    this.previews.onFilm = (style) => {
      this.paintFigure(style);
      this.paintOthers();
    };
    this.previews.onRefused = () => {
      this.paintKind();
      app.changed();
    };
    this.watcher = new IntersectionObserver((entries) => this.seen(entries), { root: this.grid, rootMargin: '40px' });
    const toggle = this.toggle = h('button', {
      className: 'quiet small', title: 'Shows or hides the figures', onclick: () => {
        this.moving = !this.moving;
        localStorage.setItem(KEPT, this.moving ? 'on' : 'off');
        toggle.setAttribute('aria-pressed', String(this.moving));
        this.paintKind();
        app.changed();
      },
    }, 'Figures');
    toggle.setAttribute('aria-pressed', String(this.moving));
    this.filter.addEventListener('input', () => this.sift());
    // Keys are shortcuts again.
    this.filter.addEventListener('keydown', ({ key }) => {
      if (key === 'Enter' || key === 'Escape') this.filter.blur();
    });
    this.element = h('div', { className: 'cards' },
      h('div', { className: 'find' }, this.filter, this.count), this.grid);
    app.watch(() => {
      if (app.version !== this.version) {
        this.previews.forgive();
        this.paintKind();
      }
      this.paint();
    });
    setInterval(() => this.paintFills(), 100);
    this.paintKind();
  }

  /** The height in pixels of so many rows of cards with figures, or as much without, if there are so many. */
  least(most: number): number {
    const rows = Math.ceil(this.cards.size / 3);
    return this.figured ? 84 * Math.min(rows, most) : 37 * Math.min(rows, Math.ceil(2.5 * most));
  }
  private get figured(): boolean {
    return this.moving && !this.previews.refused;
  }

  /** A figure elsewhere, whose style comes before those of the cards. */
  elsewhere(): Figure {
    const key = ` ${++this.made}`;
    return { show: (style, canvas) => {
      const now = this.others.get(key);
      if (style === now?.style && canvas === now?.canvas) return;
      if (style && canvas) this.others.set(key, { style, canvas });
      else this.others.delete(key);
      this.figures.hide(key);
      canvas?.getContext('2d')?.clearRect(0, 0, canvas.width, canvas.height);
      this.paintOthers();
      this.wish();
    } };
  }

  private paintOthers(): void {
    for (const [key, { style, canvas }] of this.others) {
      canvas.hidden = !this.figured;
      const film = this.figured ? this.previews.film(style) : undefined;
      if (film) this.figures.show(key, canvas, film); // until it comes, the former one is shown
      else if (!this.figured || !this.app.info(style)) this.figures.hide(key);
    }
  }

  // With or without figures.
  private paintKind(): void {
    this.grid.classList.toggle('plain', !this.figured);
    this.toggle.hidden = this.previews.refused;
    for (const name of this.cards.keys()) this.paintFigure(name);
    this.paintOthers();
    this.wish();
  }

  private paint(): void {
    const { app } = this;
    if (app.list !== this.listed || app.version !== this.version) {
      this.listed = app.list;
      this.version = app.version;
      this.paintList();
    }
    const set = new Set(app.entry()?.look?.mix.filter(({ weight }) => weight > 0).map(({ style }) => style));
    for (const [name, { pick }] of this.cards) {
      const pressed = String(set.has(name));
      if (pick.getAttribute('aria-pressed') !== pressed) pick.setAttribute('aria-pressed', pressed);
    }
  }

  private paintList(): void {
    const { app } = this;
    const infos = (app.list?.styles ?? []).filter(({ neutral }) => !neutral);
    const order = infos.map(({ name }) => name).join();
    for (const [name, card] of this.cards) {
      if (!app.info(name)) this.drop(name, card);
    }
    infos.forEach((info, place) => this.cardOf(info, place));
    if (order !== this.order) {
      this.order = order;
      this.arrange(infos.map(({ name }) => name));
    }
    this.previews.know(new Map((app.list?.styles ?? []).map((info) => [info.name, `${app.version} ${textOf(info, 20)} ${slidersOf(info)}`])));
    for (const name of this.inView) this.paintFigure(name);
    this.paintOthers();
    this.wish();
  }

  private drop(name: string, card: Card): void {
    this.watcher.unobserve(card.box);
    this.figures.hide(name);
    this.inView.delete(name);
    if (card.box.contains(document.activeElement)) {
      (card.box.nextElementSibling ?? card.box.previousElementSibling)?.querySelector('button')?.focus();
    }
    card.box.remove();
    this.cards.delete(name);
    this.order = '';
  }

  // Places the cards in order without moving those already in place, so that the focus stays.
  private arrange(names: string[]): void {
    let next = this.grid.firstElementChild;
    for (const name of names) {
      const { box } = this.cards.get(name)!;
      if (box === next) next = next.nextElementSibling;
      else this.grid.insertBefore(box, next);
    }
    this.sift();
  }

  private cardOf(info: StyleInfo, place: number): void {
    const text = textOf(info, place);
    const known = this.cards.get(info.name);
    if (known?.info === text) return;
    const { app } = this;
    const key = place >= 20 ? '' : (place < 10 ? '' : 'Shift+') + STYLE_KEYS[place % 10]!;
    const fill = h('i', {}), figure = h('span', { className: 'figure', 'aria-hidden': 'true' });
    const weakness = app.weakness(info.name);
    const pick = h('button', {
      'data-style': info.name, title: titleOf(app, info, key), onclick: () => void app.setStyle(info.name),
    }, fill, figure, h('span', { className: info.made && info.name.length > LONG ? 'name long' : 'name' }, info.name), weakness ? h('small', {}, 'weak') : undefined,
       key ? h('kbd', {}, key.replace('Shift+', '⇧')) : undefined);
    const box = h('div', { className: info.made ? 'card made' : 'card', 'data-card': info.name }, pick);
    if (info.made) {
      const more = h('button', {
        className: 'more', 'aria-haspopup': 'menu', 'aria-expanded': 'false', 'aria-label': `${info.name}: rename, export, remove`,
        title: 'Rename, export, remove', onclick: () => this.menu.open(info.name, more),
      }, '⋯');
      box.append(more);
    }
    if (known) { // in place, and with its focus
      known.box.before(box);
      if (known.box.contains(document.activeElement)) pick.focus();
      this.drop(info.name, known);
    }
    this.cards.set(info.name, { name: info.name, info: text, box, pick, fill, figure, canvas: undefined });
    this.watcher.observe(box);
    this.order = '';
  }

  // Shows the cards that match the search in name, alias, network or origin.
  private sift(): void {
    const sought = this.filter.value.trim().toLowerCase();
    let matches = 0;
    for (const [name, { box }] of this.cards) {
      const info = this.app.info(name);
      const text = info ? [name, ...info.aliases, info.model, info.source].join(' ').toLowerCase() : '';
      box.hidden = !text.includes(sought);
      if (!box.hidden) ++matches;
    }
    setText(this.count, sought ? (matches === 0 ? 'none' : `${matches} of ${this.cards.size}`) : '');
  }

  private seen(entries: IntersectionObserverEntry[]): void {
    for (const { target, isIntersecting } of entries) {
      const name = target.getAttribute('data-card')!;
      if (!this.cards.has(name)) continue;
      if (isIntersecting) this.inView.add(name);
      else this.inView.delete(name);
      this.paintFigure(name);
    }
    this.wish();
  }

  private wish(): void {
    const others = [...this.others.values()].map(({ style }) => style);
    this.previews.want(this.figured ? [...others, ...[...this.cards.keys()].filter((name) => this.inView.has(name))] : []);
  }

  // Only a card in view has a canvas.
  private paintFigure(name: string): void {
    const card = this.cards.get(name);
    if (!card) return;
    const film = this.figured && this.inView.has(name) ? this.previews.film(name) : undefined;
    if (!film) {
      this.figures.hide(name);
      card.canvas?.remove();
      card.canvas = undefined;
      return;
    }
    if (!card.canvas) {
      const dense = Math.min(devicePixelRatio, 2);
      card.canvas = h('canvas', { width: Math.round(WIDTH * dense), height: Math.round(HEIGHT * dense) });
      card.figure.append(card.canvas);
    }
    this.figures.show(name, card.canvas, film);
  }

  private paintFills(): void {
    const weights = this.inForce();
    const lit = new Set([...weights].filter(([, weight]) => weight > 0).map(([name]) => name));
    for (const name of new Set([...lit, ...this.lit])) {
      const fill = this.cards.get(name)?.fill;
      const width = `${(100 * clamp(weights.get(name) ?? 0, 0, 1)).toFixed(0)}%`;
      if (fill && fill.style.width !== width) fill.style.width = width;
    }
    this.lit = lit;
  }
}
