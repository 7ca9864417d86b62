// The state that all panels share: the client, the daemon's last replies, and requested changes.
import {
  NoAnswerError,
  RefusedError,
  type ListReply,
  type PerformerStats,
  type SetInit,
  type Stats,
  type StyledClient,
} from 'styled-client';

export class App {
  list: ListReply | undefined;
  stats: Stats | undefined;
  selected = '';
  everyone = false;
  transition_ms = 100;
  private readonly listeners = new Set<() => void>();
  onMessage: (text: string, bad: boolean) => void = () => {};

  constructor(readonly client: StyledClient) {
    client.on('stats', (stats) => {
      this.stats = stats;
      const names = this.performers().map(({ performer }) => performer);
      if (!names.includes(this.selected)) this.selected = this.live()[0] ?? names[0] ?? '';
      this.changed();
    });
    client.on('daemon', (daemon) => {
      if (daemon.up) void this.fetchList();
      else for (const entry of this.stats?.performers ?? []) entry.live = false;
      this.changed();
    });
    client.on('link', () => this.changed());
    client.subscribeStats();
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
  /** What is to be said where a style is chosen that is recognized too seldom. */
  weakness(name: string): string | undefined {
    const info = this.list?.styles.find((style) => style.name === name);
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

  private async fetchList(): Promise<void> {
    try {
      this.list = await this.client.list();
      this.changed();
    } catch (error) {
      this.report(error);
    }
  }

  get target(): string {
    return this.everyone ? '*' : this.selected;
  }

  /** Every change is sent with the transition time. */
  set(change: SetInit, what: string): Promise<void> {
    return this.run(what, () =>
      this.client.set(this.target, { ...change, transitionMs: this.transition_ms }));
  }
  setStyle(style: string): Promise<void> {
    return this.set({ mix: [{ style, weight: 1 }] }, style);
  }
  clear(): Promise<void> {
    return this.set({ clear: true }, 'bypass');
  }
  preset(name: string): Promise<void> {
    return this.run(name, () => this.client.preset(this.target, name, this.transition_ms));
  }
  panic(): Promise<void> {
    return this.run('everyone is back to the bare source', () => this.client.panic(), true);
  }
  pin(pinned: boolean): Promise<void> {
    return this.run(pinned ? 'pinned' : 'unpinned', () => this.client.pin(this.target, pinned));
  }
  reset(): Promise<void> {
    return this.run('recurrent state cleared', () => this.client.reset(this.target));
  }

  private async run(what: string, action: () => Promise<unknown>, forAll = false): Promise<void> {
    if (!forAll && !this.target) return this.onMessage('nobody is here yet', true);
    try {
      await action();
      this.onMessage(what, false);
    } catch (error) {
      this.report(error, what);
    }
  }

  // `change`: the requested change, if it may have been applied in spite of the error.
  private report(error: unknown, change = ''): void {
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
