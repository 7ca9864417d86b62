// The state that all panels share: the client, the daemon's last replies, and requested changes.
import {
  Code,
  NoAnswerError,
  RefusedError,
  type ListReply,
  type PerformerStats,
  type SetInit,
  type Stats,
  type StyleInfo,
  type StyledClient,
} from 'styled-client';

import { changeTo, sameLook, sameSetting, settingsOf, type Setting } from './looks.js';
import type { NamesInUse } from './names.js';
import { UndoStack, type Step } from './undo.js';

const LIST_MS = 10000; // other users may make and remove styles
const SETTLED_MS = 250; // after the last step of a gesture
const TRY_AGAIN = [Code.PINNED, Code.BUSY, Code.NOT_READY];

interface Manner {
  /** Of all performers, regardless of the selection. */
  forAll?: boolean;
  /** Steps of one gesture, such as a drag, are undone together. */
  gesture?: string;
  /** Whether it changes looks, and can be undone; its name then, if not the message. */
  look?: boolean;
  name?: string;
}

/** The effect of a change, once it is known. */
interface Made {
  left?: Map<string, Setting>;
}

export class App {
  list: ListReply | undefined;
  stats: Stats | undefined;
  selected = '';
  everyone = false;
  transition_ms = 100; // look.proto's initial one (tests/documents/test_look.py)
  readonly undo = new UndoStack();
  private settling = 0;
  private gesture: Made = {}; // the last one
  private reloads = '';
  private readonly missed = new Set<string>();
  private readonly listeners = new Set<() => void>();
  /** `step`: the step that the message offers to undo. */
  onMessage: (text: string, bad: boolean, step?: Step) => void = () => {};

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
  taken(): NamesInUse {
    const styles = this.list?.styles ?? [];
    const fixed = styles.filter(({ made }) => !made).flatMap(({ name, aliases }) => [name, ...aliases]);
    return { made: new Set(styles.filter(({ made }) => made).map(({ name }) => name)),
             fixed: new Set([...fixed, ...(this.list?.presets ?? []).map(({ name }) => name)]) };
  }
  /** Changes with the daemon and with its weights, and invalidates the known styles. */
  get version(): string {
    return this.reloads;
  }

  /** The warning at a style that is recognized too seldom. */
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

  // Other weights, or a look with a style that is not in the list.
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
        this.missed.add(style); // is requested once
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

  /** How these performers are set; `target` is one or "*". */
  looks(target: string): Map<string, Setting> {
    return new Map([...settingsOf(this.stats)].filter(([performer]) => target === '*' || target === performer));
  }

  /** Restores these settings of performers, and changes nothing else. A performer whose settings differ from those
  in `left` was changed by another user meanwhile: it is not changed, and its name is returned. Tries all
  performers; rejects with the first error. */
  async restore(settings: Map<string, Setting>, left?: Map<string, Setting>): Promise<string[]> {
    const presets = (this.list?.presets ?? []).map(({ name }) => name);
    const others: string[] = [];
    let failure: unknown;
    for (const [performer, setting] of settings) {
      const now = this.looks(performer).get(performer);
      const expected = left?.get(performer);
      if (now && sameSetting(now, setting)) continue;
      if (now && expected && !sameSetting(now, expected)) {
        others.push(performer);
        continue;
      }
      try {
        await this.lead(performer, now, setting, presets);
      } catch (error) {
        failure ??= error;
      }
    }
    if (failure) throw failure;
    return others;
  }

  private async lead(performer: string, now: Setting | undefined, to: Setting, presets: string[]): Promise<void> {
    let pinned = now?.pinned ?? false;
    try {
      if (now && sameLook(now.look, to.look)) return;
      if (pinned) await this.client.pin(performer, false); // otherwise the daemon refuses the look
      pinned = false;
      await this.client.set(performer, changeTo(to.look, presets, this.transition_ms));
    } finally {
      if (pinned !== to.pinned) await this.client.pin(performer, to.pinned);
    }
  }

  async undoLast(): Promise<void> {
    if (this.undo.size === 0) return this.onMessage('nothing to undo', true);
    try {
      await this.fetchLooks();
      const step = await this.undo.undo((error) => error instanceof RefusedError && !TRY_AGAIN.includes(error.code));
      if (step) this.onMessage(step.remark ? `undo of ${step.what}: ${step.remark}` : `undone: ${step.what}`, step.remark !== '');
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
    return this.run('all performers are in bypass', () => this.client.panic(), { forAll: true, look: true, name: 'panic' });
  }
  pin(pinned: boolean): Promise<void> {
    return this.run(pinned ? 'pinned' : 'unpinned', () => this.client.pin(this.target, pinned), { look: true });
  }
  /** The selected performer's own style; '': none. */
  setOwnStyle(style: string): Promise<void> {
    const performer = this.selected;
    return this.run(style ? `${performer} moves as ${style}: it is removed` : `${performer} has no style of their own`, () =>
      this.client.set(performer, { inputStyle: style, transitionMs: this.transition_ms }), { forAll: true, look: true, name: 'own style' });
  }
  /** Fires the cues of that name; false if that failed. */
  async cue(name: string): Promise<boolean> {
    let fired = false;
    await this.run(`cue ${name}`, async () => {
      await this.client.cue(name);
      fired = true;
    }, { forAll: true, look: true });
    return fired;
  }
  reset(): Promise<void> {
    return this.run('recurrent state cleared', () => this.client.reset(this.target));
  }
  /** The selected performer stands and then walks in their own way, for five seconds. */
  calibrateNeutral(): Promise<void> {
    const performer = this.selected;
    return this.run(`${performer}: stand, then walk, for 5 s`, () => this.client.calibrate(performer, { neutral: true }));
  }

  private async run(what: string, action: () => Promise<unknown>, manner: Manner = {}): Promise<void> {
    if (!manner.forAll && !this.target) return this.onMessage('no performer is present yet', true);
    const target = manner.forAll ? '*' : this.target;
    let before = this.looks(target);
    // Changes by other users in the last second are in no statistics yet. The daemon answers in
    // order.
    const asked = manner.look && !manner.gesture ? this.client.status().catch(() => undefined) : undefined;
    try {
      await action();
      this.onMessage(what, false);
    } catch (error) {
      return this.report(error, what);
    }
    const { stats } = (await asked) ?? {};
    if (stats) before = new Map([...settingsOf(stats)].filter(([performer]) => before.has(performer)));
    const made: Made = {};
    const step: Step = { what: manner.name ?? what, back: async () => {
      const others = await this.restore(before, made.left);
      return others.length > 0 ? `${others.join(', ')} ${others.length > 1 ? 'were' : 'was'} changed by another user since, and not undone` : '';
    } };
    const settle = async (made: Made) => {
      await this.fetchLooks().catch(() => {});
      made.left = this.looks(target);
    };
    if (manner.gesture) {
      if (!this.undo.push(step, manner.gesture)) this.gesture = made;
      this.onMessage(what, false, step);
      clearTimeout(this.settling);
      this.settling = window.setTimeout(() => void settle(this.gesture), SETTLED_MS);
      return this.changed();
    }
    await settle(made);
    const changed = [...before].some(([performer, setting]) => !sameSetting(setting, made.left?.get(performer) ?? setting));
    if (manner.look && changed) {
      this.undo.push(step);
      this.onMessage(what, false, step);
    }
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
