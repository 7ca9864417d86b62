// The stage's picture without WebGL: bodies and floors as lines on a 2D canvas, seen by the same camera.
import { Color, Vector3, type Matrix4, type PerspectiveCamera, type Scene } from 'three';

import { h } from './dom.js';

/** A line between two points, given by their numbers; from a point to itself it is a dot. */
export interface Line {
  from: number;
  to: number;
  width_m: number;
  shade: number; // of the color, 1: as it is
  lift_m?: number; // both ends are that much higher
}

/** Lines of one thing on the stage. */
export interface Outline {
  points: ArrayLike<number>; // x, y and z of each
  at: Matrix4; // scene from points
  lines: Line[];
  color: number;
  opacity?: number;
}

interface Stroke {
  from: Vector3; // in pixels, and z the distance from the camera in metres
  to: Vector3;
  width: number; // in pixels
  style: string;
  opacity: number;
}

const NEAREST_M = 0.1;
const EDGE = '#0c0f13';
const THIN = 3; // pixels; such a line has no edge

/** The lines as strokes on a picture of that size, the farthest first. Points behind the camera have none. */
export function strokesOf(outlines: Iterable<Outline>, camera: PerspectiveCamera, width: number, height: number): Stroke[] {
  const strokes: Stroke[] = [];
  const pixels = camera.projectionMatrix.elements[5]! * height / 2; // of a metre in a metre's distance
  const place = ({ points, at }: Outline, point: number, lift_m: number) => {
    const seen = new Vector3().fromArray(points, 3 * point).applyMatrix4(at);
    seen.y += lift_m;
    const far_m = -seen.applyMatrix4(camera.matrixWorldInverse).z;
    if (far_m < NEAREST_M) return undefined;
    seen.applyMatrix4(camera.projectionMatrix);
    return new Vector3(width * (1 + seen.x) / 2, height * (1 - seen.y) / 2, far_m);
  };
  for (const outline of outlines) {
    for (const { from, to, width_m, shade, lift_m = 0 } of outline.lines) {
      const a = place(outline, from, lift_m), b = place(outline, to, lift_m);
      if (!a || !b) continue;
      strokes.push({ from: a, to: b, width: Math.max(1, 2 * width_m * pixels / (a.z + b.z)), opacity: outline.opacity ?? 1,
                     style: `#${new Color(outline.color).multiplyScalar(shade).getHexString()}` });
    }
  }
  return strokes.sort((a, b) => b.from.z + b.to.z - a.from.z - a.to.z);
}

/** As much of three's WebGLRenderer as the stage needs. */
export class FlatRenderer {
  readonly domElement = h('canvas');
  private readonly pen = this.domElement.getContext('2d')!;
  private ratio = 1;
  private loop: ((now_ms: number) => void) | null = null;

  /** `background`: '' is transparent. */
  constructor(private readonly background: string, private readonly outlines: () => Iterable<Outline>) {}

  setPixelRatio(ratio: number): void {
    this.ratio = ratio;
  }
  getPixelRatio(): number {
    return this.ratio;
  }
  setSize(width: number, height: number): void {
    this.domElement.width = Math.round(width * this.ratio);
    this.domElement.height = Math.round(height * this.ratio);
  }

  setAnimationLoop(loop: ((now_ms: number) => void) | null): void {
    const waits = this.loop !== null; // for its next turn, which takes the new one
    this.loop = loop;
    const turn = (now_ms: number) => {
      if (!this.loop) return;
      this.loop(now_ms);
      requestAnimationFrame(turn);
    };
    if (loop && !waits) requestAnimationFrame(turn);
  }

  render(scene: Scene, camera: PerspectiveCamera): void {
    const { pen, domElement: { width, height } } = this;
    scene.updateMatrixWorld();
    camera.updateMatrixWorld();
    pen.clearRect(0, 0, width, height);
    if (this.background) {
      pen.fillStyle = this.background;
      pen.fillRect(0, 0, width, height);
    }
    pen.lineCap = 'round';
    for (const { from, to, width: wide, style, opacity } of strokesOf(this.outlines(), camera, width, height)) {
      pen.globalAlpha = opacity;
      pen.beginPath();
      pen.moveTo(from.x, from.y);
      pen.lineTo(to.x + 0.01, to.y); // a line of no length would not be drawn
      // An edge, so that an arm is visible in front of the body.
      for (const [color, more] of [[EDGE, wide > THIN ? 2 : 0], [style, 0]] as const) {
        pen.strokeStyle = color;
        pen.lineWidth = wide + more;
        pen.stroke();
      }
    }
    pen.globalAlpha = 1;
  }
}
