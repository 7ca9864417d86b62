// Checks of bodies and frames, and forward kinematics, with the same rules as
// clients/cpp/transforms.cpp.
import type { Body } from './gen/proto/styled/v1/body_pb.js';
import type { Frame } from './gen/proto/styled/v1/frame_pb.js';

const MAX_JOINTS = 1024;

/** Why `body` cannot be used, or '' if it can. */
export function checkBody(body: Body): string {
  const joints = body.names.length;
  if (joints < 1 || joints > MAX_JOINTS) return `${joints} joints, expected 1 to ${MAX_JOINTS}`;
  if (body.parents.length !== joints || body.offsets.length !== 3 * joints) {
    return `parents and offsets do not belong to ${joints} joints`;
  }
  if (body.rest.length !== 0 && body.rest.length !== 4 * joints) {
    return `rest does not belong to ${joints} joints`;
  }
  for (let joint = 0; joint < joints; ++joint) {
    const parent = body.parents[joint]!;
    if (joint === 0 ? parent !== -1 : parent < 0 || parent >= joint) {
      return `parent ${parent} of joint ${joint} does not precede it`;
    }
  }
  return body.offsets.every(Number.isFinite) ? '' : 'an offset is not finite';
}

/** Why `frame` cannot be used with `body` (which must have passed checkBody), or ''. */
export function checkFrame(body: Body, frame: Frame): string {
  if (frame.bodyHash !== body.hash || frame.output !== body.output) return 'belongs to another body';
  const joints = body.names.length;
  if (frame.rotations.length !== 4 * joints || frame.rootPosition.length !== 3) {
    return `rotations or root do not belong to ${joints} joints`;
  }
  if (!frame.rootPosition.every(Number.isFinite)) return 'its root is not finite';
  for (let joint = 0; joint < joints; ++joint) {
    if (!isRotation(frame.rotations, 4 * joint)) return `rotation ${joint} is not a rotation`;
  }
  for (const { name, position, rotation } of frame.props) {
    const whole = position.length === 3 && rotation.length === 4;
    if (!whole || !position.every(Number.isFinite) || !isRotation(rotation, 0)) return `prop "${name}" has no pose`;
  }
  return '';
}

function isRotation(q: ArrayLike<number>, at: number): boolean {
  let square = 0;
  for (let i = at; i < at + 4; ++i) square += q[i]! ** 2;
  return square >= 1e-12 && square < Infinity;
}

/** World transforms of joints (world from joint), in body units and axes. */
export interface Transforms {
  /** 3*J: x, y, z */
  positions: Float32Array;
  /** 4*J: x, y, z, w; unit length */
  rotations: Float32Array;
}

export function makeTransforms(body: Body): Transforms {
  const joints = body.names.length;
  return { positions: new Float32Array(3 * joints), rotations: new Float32Array(4 * joints) };
}

/**
 * Forward kinematics. `body` must have passed checkBody and `frame` checkFrame. Allocates nothing if
 * `out` is given (from makeTransforms(body)).
 */
export function worldTransforms(
  body: Body,
  frame: Pick<Frame, 'rootPosition' | 'rotations'>,
  out: Transforms = makeTransforms(body),
): Transforms {
  const { positions: p, rotations: r } = out;
  const q = frame.rotations;
  for (let joint = 0; joint < body.names.length; ++joint) {
    const i = 4 * joint;
    const length = Math.hypot(q[i]!, q[i + 1]!, q[i + 2]!, q[i + 3]!);
    const x = q[i]! / length, y = q[i + 1]! / length, z = q[i + 2]! / length, w = q[i + 3]! / length;
    if (joint === 0) {
      p.set(frame.rootPosition);
      r.set([x, y, z, w]);
      continue;
    }
    const parent = body.parents[joint]!;
    const a = 4 * parent;
    const px = r[a]!, py = r[a + 1]!, pz = r[a + 2]!, pw = r[a + 3]!;
    const ox = body.offsets[3 * joint]!;
    const oy = body.offsets[3 * joint + 1]!;
    const oz = body.offsets[3 * joint + 2]!;
    // v + 2 w (u x v) + 2 u x (u x v), u and w of the parent's rotation
    const tx = 2 * (py * oz - pz * oy);
    const ty = 2 * (pz * ox - px * oz);
    const tz = 2 * (px * oy - py * ox);
    p[3 * joint] = p[3 * parent]! + ox + pw * tx + py * tz - pz * ty;
    p[3 * joint + 1] = p[3 * parent + 1]! + oy + pw * ty + pz * tx - px * tz;
    p[3 * joint + 2] = p[3 * parent + 2]! + oz + pw * tz + px * ty - py * tx;
    r[i] = pw * x + px * w + py * z - pz * y;
    r[i + 1] = pw * y - px * z + py * w + pz * x;
    r[i + 2] = pw * z + px * y - py * x + pz * w;
    r[i + 3] = pw * w - px * x - py * y - pz * z;
  }
  return out;
}
