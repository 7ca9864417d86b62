// Small moving figures: a preview of the daemon as lines. Independent of the page.
import type { PreviewReply } from 'styled-client';

// The canonical humanoid (model/body/humanoid.h): the parent of each joint.
const PARENTS = [-1, 0, 1, 2, 3, 2, 5, 6, 7, 2, 9, 10, 11, 0, 13, 14, 15, 0, 17, 18, 19];
export const JOINTS = PARENTS.length;
const HEAD = 4, LEFT = new Set([5, 6, 7, 8, 13, 14, 15, 16]);
const MOST_FRAMES = 3600;
const TALL_M = 1.8; // the height that fits into the picture
const CROWN_M = 0.1; // of the head, above its joint
const TURN = 0.9; // radians; the figure walks to the right and a little towards us

export interface Film {
  rate_hz: number;
  frames: number;
  /** Frames x joints x 2: to the right and up, in metres, the ground at 0. */
  points: Float32Array;
}

/** Undefined if the reply has no figure that can be drawn. */
export function filmOf({ rateHz, joints, positionsMm }: PreviewReply): Film | undefined {
  const frames = positionsMm.length / (3 * JOINTS);
  if (joints !== JOINTS || !Number.isInteger(frames) || frames < 1 || frames > MOST_FRAMES) return undefined;
  if (!(rateHz >= 1 && rateHz <= 240)) return undefined;
  const points = new Float32Array(2 * frames * JOINTS);
  for (let i = 0; i < frames * JOINTS; ++i) {
    const x = positionsMm[3 * i]!, y = positionsMm[3 * i + 1]!, z = positionsMm[3 * i + 2]!;
    points[2 * i] = (Math.sin(TURN) * z + Math.cos(TURN) * x) / 1000;
    points[2 * i + 1] = y / 1000;
  }
  return { rate_hz: rateHz, frames, points };
}

/** The figure at a time: joints x 2, written to `out`. The last frame is followed by the first. */
export function poseAt(film: Film, time_s: number, out: Float32Array): Float32Array {
  const at = ((time_s * film.rate_hz) % film.frames + film.frames) % film.frames;
  const first = Math.floor(at) % film.frames, second = (first + 1) % film.frames, part = at - Math.floor(at);
  for (let i = 0; i < 2 * JOINTS; ++i) {
    const a = film.points[2 * JOINTS * first + i]!, b = film.points[2 * JOINTS * second + i]!;
    out[i] = a + part * (b - a);
  }
  return out;
}

export interface Ink {
  near: string;
  far: string;
  ground: string;
}

type Pen = Pick<CanvasRenderingContext2D, 'beginPath' | 'moveTo' | 'lineTo' | 'arc' | 'stroke' | 'fill' | 'clearRect'
  | 'strokeStyle' | 'fillStyle' | 'lineWidth' | 'lineCap' | 'lineJoin'>;

/** Draws the figure (of poseAt) into a picture of that size. Its right side is nearer to us. */
export function drawFigure(pen: Pen, width: number, height: number, pose: Float32Array, ink: Ink): void {
  const scale = (height - 4) / TALL_M, ground = height - 3;
  const x = (joint: number) => width / 2 + scale * pose[2 * joint]!;
  const y = (joint: number) => ground - scale * pose[2 * joint + 1]!;
  const line = (color: string, bones: (joint: number) => boolean) => {
    pen.beginPath();
    for (let joint = 1; joint < JOINTS; ++joint) {
      if (!bones(joint)) continue;
      const parent = PARENTS[joint]!;
      pen.moveTo(x(parent), y(parent));
      pen.lineTo(x(joint), y(joint));
    }
    pen.strokeStyle = color;
    pen.stroke();
  };
  pen.clearRect(0, 0, width, height);
  pen.lineCap = pen.lineJoin = 'round';
  pen.lineWidth = 1;
  pen.strokeStyle = ink.ground;
  pen.beginPath();
  pen.moveTo(width * 0.2, ground + 1.5);
  pen.lineTo(width * 0.8, ground + 1.5);
  pen.stroke();
  pen.lineWidth = Math.max(2, scale * 0.075);
  line(ink.far, (joint) => LEFT.has(joint));
  line(ink.near, (joint) => !LEFT.has(joint));
  pen.beginPath();
  pen.arc(x(HEAD), y(HEAD) - scale * 0.04, scale * CROWN_M, 0, 2 * Math.PI);
  pen.fillStyle = ink.near;
  pen.fill();
}
