// Draws the small moving figures: one loop for all that are in view, at most 15 pictures a second, none
// while nothing is in view. With reduced motion preferred, they stand still.
import { JOINTS, drawFigure, poseAt, type Film } from './pictures.js';
import { lightScheme, schemeColor } from './scheme.js';

const PICTURE_MS = 1000 / 15;
const STILL_S = 0.4; // position in the film that is shown without motion

const reduced = matchMedia('(prefers-reduced-motion: reduce)');

const inkOf = () => ({ near: schemeColor('--ink-near'), far: schemeColor('--ink-far'), ground: schemeColor('--ink-ground') });

export class Figures {
  private readonly shown = new Map<string, { canvas: HTMLCanvasElement; film: Film; begun_ms: number; drawn: boolean }>();
  private readonly pose = new Float32Array(2 * JOINTS);
  private running = false;
  private last_ms = 0;
  /** Pictures drawn of all figures; for tests. */
  pictures = 0;
  private ink = inkOf();

  constructor() {
    for (const change of [reduced, lightScheme]) {
      change.addEventListener('change', () => {
        this.ink = inkOf();
        for (const figure of this.shown.values()) figure.drawn = false;
        this.wake();
      });
    }
  }

  show(name: string, canvas: HTMLCanvasElement, film: Film): void {
    const known = this.shown.get(name);
    if (known?.canvas === canvas && known.film === film) return;
    this.shown.set(name, { canvas, film, begun_ms: performance.now(), drawn: false });
    this.wake();
  }
  hide(name: string): void {
    this.shown.delete(name);
  }

  private wake(): void {
    if (this.running || this.shown.size === 0) return;
    this.running = true;
    requestAnimationFrame((now_ms) => this.step(now_ms));
  }

  private step(now_ms: number): void {
    if (now_ms - this.last_ms >= PICTURE_MS - 2) {
      this.last_ms = now_ms;
      for (const figure of this.shown.values()) {
        if (reduced.matches && figure.drawn) continue;
        const { canvas, film } = figure;
        const pen = canvas.getContext('2d');
        if (!pen) continue;
        poseAt(film, reduced.matches ? STILL_S : (now_ms - figure.begun_ms) / 1000, this.pose);
        drawFigure(pen, canvas.width, canvas.height, this.pose, this.ink);
        figure.drawn = true;
        ++this.pictures;
      }
    }
    this.running = this.shown.size > 0 && !(reduced.matches && [...this.shown.values()].every(({ drawn }) => drawn));
    if (this.running) requestAnimationFrame((next_ms) => this.step(next_ms));
  }
}
