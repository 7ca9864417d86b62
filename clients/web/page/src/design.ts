// Styles by hand: what sliders show, what a style begins with, and when changes are sent. Knows neither page nor
// daemon; pinned by test/design.test.mjs.
import type { ListReply, SliderInfo } from 'styled-client';

/** A style by hand. It has a value of every slider, so that it does not depend on what was sent before. */
export interface Design {
  /** The style that it begins with. */
  from: string;
  sliders: Record<string, number>;
}

type Known = Pick<ListReply, 'styles' | 'sliders' | 'designs'>;

/** The daemon's name for a performer's style by hand (daemon/styles/style_requests.cpp). */
export function handName(performer: string): string {
  return `by-hand-${performer}`.replace(/[^A-Za-z0-9_-]/g, '-').slice(0, 32);
}

/** The possible beginnings of a style: groups of choices. Each has a value for `designOf` and its words. */
export function choicesOf({ styles, designs }: Known): { group: string; choices: { value: string; words: string }[] }[] {
  const style = (name: string) => ({ value: `style ${name}`, words: name });
  const neutral = styles.filter(({ neutral }) => neutral).map(({ name }) => ({ ...style(name), words: 'the performer, neutral' }));
  return [
    { group: '', choices: neutral },
    { group: 'Designs', choices: designs.map(({ name }) => ({ value: `design ${name}`, words: name })) },
    { group: 'Made styles', choices: styles.filter(({ made }) => made).map(({ name }) => style(name)) },
    { group: 'Styles', choices: styles.filter(({ made, neutral, designable }) => designable && !made && !neutral).map(({ name }) => style(name)) },
  ].filter(({ choices }) => choices.length > 0);
}

/** The design that a choice begins with; undefined if there is no such style or design. */
export function designOf({ styles, sliders, designs }: Known, choice: string): Design | undefined {
  const [kind, name] = choice.split(' ');
  const design = kind === 'design' ? designs.find((one) => one.name === name) : undefined;
  const style = kind === 'design' ? styles.find(({ neutral }) => neutral) : styles.find((one) => one.name === name);
  if (!style || (kind === 'design' && !design)) return undefined;
  const own = design?.sliders ?? style.sliders;
  return { from: style.name, sliders: Object.fromEntries(sliders.map(({ name, usual }) => [name, own[name] ?? usual])) };
}

/** Equal values as the daemon stores them, in single precision. */
export function sameSliders(a: Design, b: Design): boolean {
  const names = Object.keys(a.sliders);
  return names.length === Object.keys(b.sliders).length && names.every((name) => Math.fround(a.sliders[name]!) === Math.fround(b.sliders[name] ?? NaN));
}

/** How far a knob moves at a time. */
export function stepOf({ least, most }: Pick<SliderInfo, 'least' | 'most'>): number {
  const span = most - least;
  return span > 20 ? 1 : span > 2 ? 0.1 : 0.01;
}

const round = (value: number) => String(Math.round(100 * value) / 100);

/** A value with its unit, short to read and whole to hear. */
export function wordsOf(unit: string, value: number): { read: string; heard: string } {
  const number = round(value);
  if (unit === 'degrees') return { read: `${number}°`, heard: `${number} degrees` };
  if (unit === 's') return { read: `${number} s`, heard: `${number} seconds` };
  return unit ? { read: `${number} ${unit}`, heard: `${number} ${unit}` } : { read: `× ${number}`, heard: `times ${number}` };
}

/** The sliders by group, in the daemon's order. */
export function groupsOf(sliders: SliderInfo[]): Map<string, SliderInfo[]> {
  const groups = new Map<string, SliderInfo[]>();
  for (const slider of sliders) groups.set(slider.group, [...(groups.get(slider.group) ?? []), slider]);
  return groups;
}

/** Sends values, one at a time. While one is on its way, the newest of each key waits. `send` reports its
errors itself. `rest` is called once nothing was sent for `rest_ms`. */
export class Live<T> {
  private readonly waiting = new Map<string, T>();
  private running: Promise<void> | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly send: (key: string, value: T) => Promise<void>, private readonly rest: () => void,
              private readonly rest_ms = 400) {}

  put(key: string, value: T): void {
    this.waiting.set(key, value);
    clearTimeout(this.timer);
    this.running ??= this.run();
  }

  /** Drops the waiting value of that key. */
  drop(key: string): void {
    this.waiting.delete(key);
  }

  /** Resolves once nothing is on its way and nothing waits. */
  async settled(): Promise<void> {
    while (this.running) await this.running;
  }

  private async run(): Promise<void> {
    try {
      for (let next = this.next(); next; next = this.next()) await this.send(...next);
    } finally {
      this.running = undefined;
      this.timer = setTimeout(this.rest, this.rest_ms);
    }
  }

  private next(): [string, T] | undefined {
    const [next] = this.waiting;
    if (next) this.waiting.delete(next[0]);
    return next;
  }
}
