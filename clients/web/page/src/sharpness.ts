// How many pixels are drawn where the processor draws: motion counts more than edges.

const LEAST = 0.6;
const STEP = 0.1;
const SLOW_FPS = 26; // below it there are fewer at once
const QUICK_FPS = 40; // above it, for some seconds on end, there are more again
const PATIENCE = 5; // seconds of quick pictures
const MOST_PATIENCE = 80;

/** The ratio of pixels drawn to pixels shown, asked once a second. */
export class Sharpness {
  private quick = 0; // seconds on end
  private sinceRise = Infinity;
  private patience = PATIENCE;

  constructor(private ratio: number, private readonly most = ratio) {}

  /** `fps`: of the last second. */
  next(fps: number): number {
    ++this.sinceRise;
    this.quick = fps >= QUICK_FPS ? this.quick + 1 : 0;
    if (fps < SLOW_FPS && this.ratio > LEAST) {
      // What was too much just now is not tried again so soon.
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
