// The resolution with software rendering: smooth motion matters more than sharp edges.

const LEAST = 0.6;
const STEP = 0.1;
const SLOW_FPS = 26; // below it, the resolution is reduced at once
const QUICK_FPS = 40; // above it for some seconds without a break, the resolution is increased
const PATIENCE = 5; // that number of seconds
const MOST_PATIENCE = 80;

/** The ratio of pixels drawn to pixels shown; call once per second. */
export class Sharpness {
  private quick = 0; // consecutive seconds above QUICK_FPS
  private sinceRise = Infinity;
  private patience = PATIENCE;

  constructor(private ratio: number, private readonly most = ratio) {}

  /** `fps`: of the last second. */
  next(fps: number): number {
    ++this.sinceRise;
    this.quick = fps >= QUICK_FPS ? this.quick + 1 : 0;
    if (fps < SLOW_FPS && this.ratio > LEAST) {
      // A resolution that was too slow a moment ago is not retried as soon.
      this.patience = this.sinceRise <= 2 * PATIENCE ? Math.min(MOST_PATIENCE, 2 * this.patience) : PATIENCE;
      this.ratio = Math.max(LEAST, this.ratio - STEP);
    } else if (this.quick >= this.patience && this.ratio < this.most) {
      this.ratio = Math.min(this.most, this.ratio + STEP);
      this.quick = 0;
      this.sinceRise = 0;
    }
    return this.ratio;
  }
}
