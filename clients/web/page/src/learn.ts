// The course of a take: countdown, take, and the same for a neutral one before it. Knows neither page
// nor daemon; time is an argument.

export const COUNT_S = 3;

export type What = 'neutral' | 'style';

/** The state to display. */
export type Phase =
  | { kind: 'count'; what: What; left: number } // 3, 2, 1
  | { kind: 'take'; what: What; part: number; left_s: number } // part: 0 to 1
  | { kind: 'wait'; what: What } // the take is over, the reply is pending
  | { kind: 'over' };

export class Course {
  private readonly takes: What[];
  private begun_ms: number;
  private counting = true;
  private over = false;

  constructor(readonly seconds: number, neutral: boolean, now_ms: number) {
    this.takes = neutral ? ['neutral', 'style'] : ['style'];
    this.begun_ms = now_ms;
  }

  at(now_ms: number): Phase {
    const what = this.takes[0];
    if (this.over || !what) return { kind: 'over' };
    const since_s = Math.max(0, (now_ms - this.begun_ms) / 1000);
    if (this.counting) return { kind: 'count', what, left: Math.max(1, Math.ceil(COUNT_S - since_s)) };
    const part = since_s / this.seconds;
    return part < 1 ? { kind: 'take', what, part, left_s: this.seconds - since_s } : { kind: 'wait', what };
  }

  /** Whether the countdown has ended and the take should be requested; call `go` then. */
  due(now_ms: number): boolean {
    return !this.over && this.takes.length > 0 && this.counting && now_ms - this.begun_ms >= 1000 * COUNT_S;
  }
  go(now_ms: number): void {
    this.counting = false;
    this.begun_ms = now_ms;
  }

  /** The reply to a take has arrived: the next one begins with its countdown, or the course ends.
  */
  done(now_ms: number): void {
    this.takes.shift();
    this.counting = true;
    this.begun_ms = now_ms;
  }

  stop(): void {
    this.over = true;
  }
}
