// Whether a style of an example turns out to be ordinary motion: the daemon, which measures how far a style moves
// a body, calls a performer who wears it and nothing else hardly styled. Pinned by test/ordinary.test.mjs.
import type { PerformerStats } from 'styled-client';

const TIMES = 2; // statistics in a row: a part of the first one may be from before the style

export class Ordinary {
  private times = 0;

  constructor(private readonly performer: string, private readonly style: string) {}

  /** With these statistics, whether nothing of the style is visible; undefined: the performer does not show it. */
  heard(performers: readonly Pick<PerformerStats, 'performer' | 'live' | 'look' | 'hardlyStyled'>[]): boolean | undefined {
    const entry = performers.find(({ performer }) => performer === this.performer);
    const worn = (entry?.look?.mix ?? []).filter(({ weight }) => weight > 0);
    const shown = entry?.live && worn.length === 1 && worn[0]!.style === this.style;
    this.times = shown && entry.hardlyStyled ? this.times + 1 : 0;
    return shown ? this.times >= TIMES : undefined;
  }
}
