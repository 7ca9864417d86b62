// A take as the columns of numbers that glTF's animations have.
import { breather } from './save.js';
import type { Replay } from './replay.js';

/** Values of one thing in every frame, `width` numbers each. */
export class Column {
  readonly values: Float32Array;
  private length = 0;

  constructor(readonly width: number, frames: number) {
    this.values = new Float32Array(width * frames);
  }

  add(values: ArrayLike<number>): void {
    this.values.set(values, this.length);
    this.length += this.width;
  }

  /** Four numbers of `from`, a rotation (x, y, z, w) of any length; of its two signs the one nearer to the frame before. */
  addRotation(from: ArrayLike<number>, at = 0): void {
    const { values, length: to } = this;
    let square = 0, dot = 0;
    for (let k = 0; k < 4; ++k) {
      square += from[at + k]! ** 2;
      if (to > 0) dot += from[at + k]! * values[to - 4 + k]!;
    }
    const scale = (dot < 0 ? -1 : 1) / Math.sqrt(square);
    for (let k = 0; k < 4; ++k) values[to + k] = from[at + k]! * scale;
    this.length += 4;
  }

  /** Whether all values equal this one within `most`. */
  stays(value: ArrayLike<number>, most: number): boolean {
    return this.values.every((x, i) => Math.abs(x - value[i % this.width]!) <= most);
  }
}

type CanonicalFrame = NonNullable<ReturnType<Replay['at']>>;

/** Calls `take` with each frame of the styled motion of the canonical humanoid, and returns the frames' times
in seconds. The page stays responsive; `rest` is called before, and at the end. */
export async function everyFrame(replay: Replay, take: (of: CanonicalFrame) => void, rest: () => void = () => {}): Promise<Float32Array> {
  const breathe = breather();
  const times = new Float32Array(replay.frames);
  for (let i = 0; i < replay.frames; ++i) {
    times[i] = i / replay.rate_hz;
    take(replay.at('canonical', i / replay.rate_hz)!);
    const pause = breathe();
    if (!pause) continue;
    rest();
    await pause;
  }
  rest();
  return times;
}
