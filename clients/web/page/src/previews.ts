// Fetches previews of styles: one at a time, and only those that the page shows now.
import { Code, RefusedError, type PreviewReply } from 'styled-client';

import { filmOf, type Film } from './pictures.js';

const PAUSE_MS = 30; // between two requests, so that others get their turn
const AGAIN_MS = 2000;

export class Previews {
  private readonly films = new Map<string, { version: string; film: Film | undefined }>();
  private wanted: string[] = [];
  private version = new Map<string, string>();
  private busy = false;
  private timer: ReturnType<typeof setTimeout> | undefined;
  /** The daemon has no previews. */
  refused = false;
  onFilm: (style: string) => void = () => {};
  onRefused: () => void = () => {};

  constructor(private readonly ask: (style: string) => Promise<PreviewReply>) {}

  /** The existing styles, each with a text that changes when the style does. Others are dropped. */
  know(styles: Map<string, string>): void {
    this.version = styles;
    for (const [style, { version }] of this.films) if (styles.get(style) !== version) this.films.delete(style);
  }

  film(style: string): Film | undefined {
    return this.films.get(style)?.film;
  }

  /** Another daemon may have previews. */
  forgive(): void {
    this.refused = false;
    this.step();
  }

  /** The styles whose pictures are in view, most wanted first. */
  want(styles: string[]): void {
    this.wanted = styles;
    this.step();
  }

  private step(): void {
    if (this.busy || this.refused || this.timer !== undefined) return;
    const style = this.wanted.find((name) => this.version.has(name) && !this.films.has(name));
    if (style !== undefined) void this.fetch(style);
  }

  private later(ms: number): void {
    this.timer = setTimeout(() => {
      this.timer = undefined;
      this.step();
    }, ms);
  }

  private async fetch(style: string): Promise<void> {
    this.busy = true;
    const version = this.version.get(style)!;
    let pause_ms = PAUSE_MS;
    try {
      const film = filmOf(await this.ask(style));
      if (this.version.get(style) === version) {
        this.films.set(style, { version, film });
        this.onFilm(style);
      }
    } catch (error) {
      if (error instanceof RefusedError && (error.code === Code.UNKNOWN_COMMAND || error.code === Code.UNAUTHORIZED)) {
        this.refused = true;
        this.onRefused();
      } else if (error instanceof RefusedError && error.code !== Code.BUSY) {
        this.films.set(style, { version, film: undefined }); // this style has none
      } else {
        pause_ms = AGAIN_MS;
      }
    }
    this.busy = false;
    this.later(pause_ms);
  }
}
