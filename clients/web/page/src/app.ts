// The state that all panels share: the client, the daemon's last replies, and requested changes.
import {
  Code,
  NoAnswerError,
  RefusedError,
  type ListReply,
  type Look,
  type PerformerStats,
  type SetInit,
  type Stats,
  type StyleInfo,
  type StyledClient,
} from 'styled-client';

import { changeTo, sameLook } from './looks.js';
import type { Taken } from './names.js';
import { UndoStack } from './undo.js';

const LIST_MS = 10000; // others may make and remove styles
const SETTLED_MS = 250; // after the last step of a gesture
const TRY_AGAIN = [Code.PINNED, Code.BUSY, Code.NOT_READY];

interface Manner {
  /** Of everyone, whoever is selected. */
  forAll?: boolean;
  /** Steps of one gesture, such as a drag, are taken back together. */
  gesture?: string;
  /** Whether it changes looks, and can be taken back; its name then, if not the message. */
  look?: boolean;
  name?: string;
}

export class App {
  list: ListReply | undefined;
  stats: Stats | undefined;
  selected = '';
  everyone = false;
  transition_ms = 100;
  readonly undo = new UndoStack();
  private settling = 0;
  private reloads = '';
  private readonly missed = new Set<string>();
  private readonly listeners = new Set<() => void>();
  onMessage: (text: string, bad: boolean) => void = () => {};

  constructor(readonly client: StyledClient) {
    client.on('stats', (stats) => {
      this.stats = stats;
      const names = this.performers().map(({ performer }) => performer);
      if (!names.includes(this.selected)) this.selected = this.live()[0] ?? names[0] ?? '';
      if (this.listIsOld()) void this.fetchList();
      this.changed();
    });
    client.on('daemon', (daemon) => {
      if (daemon.up) void this.fetchList();
      else for (const entry of this.stats?.performers ?? []) entry.live = false;
      this.changed();
    });
    client.on('link', () => this.changed());
    client.subscribeStats();
    setInterval(() => {
      if (!document.hidden && client.daemonState.up) void this.fetchList(true);
    }, LIST_MS);
  }

  /** The gateway refuses all changes. */
  get watchOnly(): boolean {
    return this.client.watchOnly;
  }

  /** Calls back whenever anything here changes. */
  watch(listener: () => void): void {
    this.listeners.add(listener);
  }
  changed(): void {
    for (const listener of this.listeners) listener();
  }

  performers(): PerformerStats[] {
    return [...(this.stats?.performers ?? [])].sort((a, b) => a.performer.localeCompare(b.performer));
  }
  live(): string[] {
    return this.performers().filter(({ live }) => live).map(({ performer }) => performer);
  }
  entry(): PerformerStats | undefined {
    return this.stats?.performers.find(({ performer }) => performer === this.selected);
  }
  info(name: string): StyleInfo | undefined {
    return this.list?.styles.find((style) => style.name === name);
  }
  taken(): Taken {
    const styles = this.list?.styles ?? [];
    const fixed = styles.filter(({ made }) => !made).flatMap(({ name, aliases }) => [name, ...aliases]);
    return { made: new Set(styles.filter(({ made }) => made).map(({ name }) => name)),
             fixed: new Set([...fixed, ...(this.list?.presets ?? []).map(({ name }) => name)]) };
  }
  /** Changes with the daemon and with its weights: what is known of styles is void then. */
  get version(): string {
    return this.reloads;
  }

  /** What is to be said where a style is chosen that is recognized too seldom. */
  weakness(name: string): string | undefined {
    const info = this.info(name);
    if (!info?.weak) return undefined;
    return `weak: recognized in ${Math.floor(100 * info.recognized)} % of test windows`;
  }

  styles(): string[] {
    return (this.list?.styles ?? []).filter(({ neutral }) => !neutral).map(({ name }) => name);
  }

  select(name: string): void {
    if (name === this.selected) return;
    this.selected = name;
    this.changed();
  }
  selectNext(step: number): void {
    const names = this.performers().map(({ performer }) => performer);
    if (names.length === 0) return;
    const at = names.indexOf(this.selected);
    this.select(names[(at + step + names.length) % names.length]!);
  }

  // Other weights, or a look that names a style which the list has not.
  private listIsOld(): boolean {
    const reloads = this.stats?.counters.find(({ name }) => name === 'config.reloads')?.value ?? 0n;
    const now = `${this.stats?.epoch} ${reloads}`;
    let old = now !== this.reloads;
    this.reloads = now;
    if (!this.list) return false;
    const known = new Set(this.list.styles.map(({ name }) => name));
    for (const { look } of this.performers()) {
      for (const { style } of look?.mix ?? []) {
        if (known.has(style) || this.missed.has(style)) continue;
        this.missed.add(style); // is asked for once
        old = true;
      }
    }
    return old;
  }

  async fetchList(quiet = false): Promise<void> {
    try {
      this.list = await this.client.list();
      this.changed();
    } catch (error) {
      if (!quiet) this.report(error);
    }
  }

  /** The looks as they are now, not as of the last second. */
  async fetchLooks(): Promise<void> {
    const { stats } = await this.client.status();
    for (const { performer, look, pinned } of stats?.performers ?? []) {
      const entry = this.stats?.performers.find((other) => other.performer === performer);
      if (!entry) continue;
      if (look) entry.look = look;
      entry.pinned = pinned;
    }
    this.changed();
  }

  /** What these performers look like; `target` is one or "*". */
  looks(target: string): Map<string, Look> {
    return new Map(this.performers().flatMap(({ performer, look }) =>
      look && (target === '*' || target === performer) ? [[performer, look] as const] : []));
  }

  /** Leads performers back to these looks. Tries all of them; rejects with the first error. */
  async restore(looks: Map<string, Look>): Promise<void> {
    const presets = (this.list?.presets ?? []).map(({ name }) => name);
    let failure: unknown;
    for (const [performer, look] of looks) {
      const now = this.looks(performer).get(performer);
      if (now && sameLook(now, look)) continue;
      try {
        await this.client.set(performer, changeTo(look, presets, this.transition_ms));
      } catch (error) {
        failure ??= error;
      }
    }
    if (failure) throw failure;
  }

  async undoLast(): Promise<void> {
    if (this.undo.size === 0) return this.onMessage('nothing to undo', true);
    try {
      await this.fetchLooks();
      const step = await this.undo.undo((error) => error instanceof RefusedError && !TRY_AGAIN.includes(error.code));
      if (step) this.onMessage(`undone: ${step.what}`, false);
    } catch (error) {
      this.report(error, 'undo');
    }
    await this.refresh();
  }

  /** After a change of styles or looks. */
  async refresh(): Promise<void> {
    await this.fetchList(true);
    await this.fetchLooks().catch(() => this.changed());
  }

  get target(): string {
    return this.everyone ? '*' : this.selected;
  }

  /** Every change is sent with the transition time. */
  set(change: SetInit, what: string, gesture = ''): Promise<void> {
    return this.run(what, () =>
      this.client.set(this.target, { ...change, transitionMs: this.transition_ms }), { look: true, gesture });
  }
  setStyle(style: string): Promise<void> {
    return this.set({ mix: [{ style, weight: 1 }] }, style);
  }
  clear(): Promise<void> {
    return this.set({ clear: true }, 'bypass');
  }
  preset(name: string): Promise<void> {
    return this.run(name, () => this.client.preset(this.target, name, this.transition_ms), { look: true });
  }
  panic(): Promise<void> {
    return this.run('everyone is back to the bare source', () => this.client.panic(), { forAll: true, look: true, name: 'panic' });
  }
  pin(pinned: boolean): Promise<void> {
    return this.run(pinned ? 'pinned' : 'unpinned', () => this.client.pin(this.target, pinned));
  }
  reset(): Promise<void> {
    return this.run('recurrent state cleared', () => this.client.reset(this.target));
  }

  private async run(what: string, action: () => Promise<unknown>, manner: Manner = {}): Promise<void> {
    if (!manner.forAll && !this.target) return this.onMessage('nobody is here yet', true);
    const before = this.looks(manner.forAll ? '*' : this.target);
    try {
      await action();
      this.onMessage(what, false);
    } catch (error) {
      return this.report(error, what);
    }
    const step = { what: manner.name ?? what, back: () => this.restore(before) };
    if (manner.gesture) {
      this.undo.push(step, manner.gesture);
      clearTimeout(this.settling);
      this.settling = window.setTimeout(() => void this.fetchLooks().catch(() => {}), SETTLED_MS);
      return this.changed();
    }
    await this.fetchLooks().catch(() => {});
    const changed = [...before].some(([performer, look]) => !sameLook(look, this.looks(performer).get(performer) ?? look));
    if (manner.look && changed) this.undo.push(step);
    this.changed();
  }

  // `change`: the requested change, if it may have been applied in spite of the error.
  report(error: unknown, change = ''): void {
    if (!(error instanceof RefusedError || error instanceof NoAnswerError)) throw error;
    const open = change && error instanceof NoAnswerError && error.sent;
    this.onMessage(open ? `${change}: ${error.message}; it may still be applied` : error.message, true);
  }
}

/** At most one call at a time; the newest argument wins. For sliders that are dragged. */
export function paced<T>(action: (value: T) => Promise<void>): (value: T) => void {
  let busy = false;
  let waiting: [T] | undefined;
  const run = async (value: T) => {
    busy = true;
    await action(value);
    busy = false;
    if (!waiting) return;
    const [next] = waiting;
    waiting = undefined;
    void run(next);
  };
  return (value) => {
    if (busy) waiting = [value];
    else void run(value);
  };
}
