// Operations on styles from examples; each step can be undone.
import { Code, RefusedError, type LikeReply } from 'styled-client';

import type { App } from './app.js';
import type { Design } from './design.js';
import type { Setting } from './looks.js';
import { saveFile } from './save.js';

export const MOST_BYTES = 8 * 1024 * 1024 - 4096; // of a request, for its clip

// The style was made, but the performer could not be shown in it.
const NOT_SHOWN = [Code.PINNED, Code.UNKNOWN_PERFORMER, Code.NOT_READY];

/** The result of an example, for the panel. */
export interface Outcome {
  text: string;
  bad: boolean;
  /** The parts that the example shows, and their weaknesses. */
  found?: string[];
  weak?: string[];
}

const size = (bytes: number) =>
  bytes < 1e5 ? `${(bytes / 1024).toFixed(1)} KiB` : `${(bytes / 1024 / 1024).toFixed(1)} MiB`;

/** Why a file cannot be sent, or ''. */
export function fileFault(file: { name: string; size: number }): string {
  if (file.size === 0) return `${file.name} is empty.`;
  return file.size > MOST_BYTES ? `${file.name} has ${size(file.size)}, expected at most ${size(MOST_BYTES)}.` : '';
}

/** The reply's description of the example. */
export function outcomeOf(reply: LikeReply, from: string, wearer: string, add = false): Outcome {
  const seconds = reply.seconds > 0 ? ` (${reply.seconds.toFixed(1)} s)` : '';
  const worn = wearer ? '' : ' No performer wears it yet.';
  const near = reply.nearest ? ` Nearest: ${reply.nearest}, distance ${reply.distance.toFixed(2)}.` : '';
  const { found, weak } = reply;
  const far = reply.distance > 1 && found.length === 0; // what is measured is as good far from the known styles
  const warning = far ? ' It is unlike all styles that the network knows: expect a weak mixture of similar ones.' : '';
  const made = add ? `${from} is added to ${reply.name}` : `${reply.name} is made from ${from}`;
  return { text: `${made}${seconds}.${worn}${near}${warning}`, bad: far, found, weak };
}

export class Examples {
  constructor(private readonly app: App) {}

  /** The step that undoes a style of this name that is about to be made: restores the former one, or
  removes it. */
  async former(name: string): Promise<() => Promise<void>> {
    const { client } = this.app;
    if (!this.app.taken().made.has(name)) {
      return async () => {
        // A daemon that cannot remove a style keeps it in its list.
        await client.removeStyle(name).catch((error: unknown) => {
          if (!(error instanceof RefusedError && error.code === Code.UNKNOWN_COMMAND)) throw error;
        });
      };
    }
    const { file } = await client.exportStyle(name);
    return async () => {
      await client.importStyle(file, { name, replace: true });
    };
  }

  /** Stores how to undo a style that was made. */
  made(name: string, looks: Map<string, Setting>, back: () => Promise<void>): void {
    this.app.undo.push({
      what: name,
      back: async () => {
        await this.app.restore(looks);
        await back();
      },
    });
  }

  /** `add`: the example is added to the made style of that name. */
  async like(name: string, clip: Uint8Array, file: string, add: boolean): Promise<Outcome> {
    const { app } = this;
    const target = app.target, looks = app.looks(target);
    const back = await this.former(name);
    try {
      const reply = await app.client.like(target, { name, clip, file, add, transitionMs: app.transition_ms });
      this.made(name, looks, back);
      return outcomeOf(reply, file, target, add);
    } catch (error) {
      if (!(error instanceof RefusedError && NOT_SHOWN.includes(error.code))) throw error;
      this.made(name, looks, back);
      return { text: `${name} is made from ${file}, but no performer wears it: ${error.message}`, bad: true };
    } finally {
      await app.refresh();
    }
  }

  /** Keeps a style by hand under a name; false if that failed. */
  async design(name: string, { from, sliders }: Design): Promise<boolean> {
    let kept = false;
    await this.attempt(`${name} is saved`, async () => {
      const back = await this.former(name);
      await this.app.client.design('', { name, from, sliders });
      this.made(name, new Map(), back);
      kept = true;
    });
    return kept;
  }

  /** Adds the style of a file of the library. */
  async add(name: string, file: Uint8Array): Promise<Outcome> {
    const { app } = this;
    const back = await this.former(name);
    try {
      const replace = app.taken().made.has(name);
      const reply = await app.client.importStyle(file, { name, replace });
      this.made(name, new Map(), back);
      return outcomeOf(reply, 'its file', ' ');
    } finally {
      await app.refresh();
    }
  }

  /** Saves the style's file. */
  save(name: string): Promise<void> {
    return this.attempt(`${name}.json is saved`, async () => {
      const { file } = await this.app.client.exportStyle(name);
      saveFile(new Blob([new Uint8Array(file)], { type: 'application/json' }), `${name}.json`);
    });
  }

  rename(name: string, to: string): Promise<void> {
    return this.attempt(`${name} is now ${to}`, async () => {
      await this.app.client.renameStyle(name, to);
      this.app.undo.push({ what: `${name} renamed to ${to}`, back: async () => void (await this.app.client.renameStyle(to, name)) });
    });
  }

  /** Its file is kept here, so that it can be restored. */
  remove(name: string): Promise<void> {
    return this.attempt(`${name} is removed; Undo restores it`, async () => {
      const { app } = this;
      const { file } = await app.client.exportStyle(name);
      const looks = new Map([...app.looks('*')].filter(([, { look }]) => look.mix.some(({ style }) => style === name)));
      await app.client.removeStyle(name);
      app.undo.push({
        what: `${name} removed`,
        back: async () => {
          await app.client.importStyle(file, { name });
          await app.restore(looks);
        },
      });
    });
  }

  private async attempt(what: string, action: () => Promise<void>): Promise<void> {
    try {
      await action();
      this.app.onMessage(what, false);
    } catch (error) {
      this.app.report(error, what);
    }
    await this.app.refresh();
  }
}
