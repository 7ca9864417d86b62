// The steps that can be undone. Knows neither page nor daemon.

const MOST = 50;
const GESTURE_MS = 1500;

export interface Step {
  /** The name of the step, for messages. */
  what: string;
  /** Undoes the step; resolves to an additional remark; rejects if that fails. */
  back(): Promise<string | void>;
}

interface Entry extends Step {
  gesture: string;
  at_ms: number;
}

export class UndoStack {
  private readonly entries: Entry[] = [];
  private busy = false;

  constructor(private readonly now_ms: () => number = () => performance.now()) {}

  get size(): number {
    return this.entries.length;
  }
  get last(): Step | undefined {
    return this.entries.at(-1);
  }

  /** Adds a step. Steps of one gesture (a knob that is dragged) that follow each other closely are merged, and
  lead back to the beginning of the first: then the result is true, and this `back` is never called. The oldest
  of more than fifty is dropped. */
  push(step: Step, gesture = ''): boolean {
    const last = this.entries.at(-1);
    const at_ms = this.now_ms();
    if (gesture && last?.gesture === gesture && at_ms - last.at_ms < GESTURE_MS) {
      last.at_ms = at_ms;
      last.what = step.what;
      return true;
    }
    this.entries.push({ what: step.what, back: () => step.back(), gesture, at_ms });
    if (this.entries.length > MOST) this.entries.shift();
    return false;
  }

  /** Undoes the last step. Resolves to the step's name and the result of `back`; to undefined if there is no
  step, or if another one is being undone. A step that fails is kept for another try, unless `lost` says that no
  try can succeed. */
  async undo(lost: (error: unknown) => boolean = () => false): Promise<{ what: string; remark: string } | undefined> {
    if (this.busy) return undefined;
    const entry = this.entries.pop();
    if (!entry) return undefined;
    this.busy = true;
    try {
      return { what: entry.what, remark: (await entry.back()) ?? '' };
    } catch (error) {
      if (!lost(error)) this.entries.push(entry);
      throw error;
    } finally {
      this.busy = false;
    }
  }
}
