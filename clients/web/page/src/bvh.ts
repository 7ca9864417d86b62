// Writes BVH like model/clip/bvh_write.cpp: root XYZ + zxy, others zxy, angles continuous over
// time, %.6f, body units. The root's OFFSET is 0, like in stylerec's exports: its position is in
// the position channels, and many readers would add the offset to them.
import type { Body } from 'styled-client';

const DEGREES = 180 / Math.PI;
const GIMBAL = 1e-6;
const ROWS = 64; // frames in one piece of text

type Pose = ArrayLike<number>; // 3 of the root, then x, y, z, w per joint

/** `angle` plus the number of full turns that brings it nearest to `near`. */
function unwrap(angle: number, near: number): number {
  return angle + 2 * Math.PI * Math.round((near - angle) / (2 * Math.PI));
}

const distance = (angles: number[], near: ArrayLike<number>) =>
  angles.reduce((sum, angle, i) => sum + Math.abs(angle - near[i]!), 0);

/**
 * Solves R = Rz(a) Rx(b) Ry(c), in radians, for the solution nearer to `near`, unwrapped. If b is a
 * quarter turn, only a + c or a - c is determined, and a keeps its value. Pinned by test/bvh.test.mjs.
 */
function eulerOf(pose: Pose, at: number, near: ArrayLike<number>, first: boolean): number[] {
  const length = Math.hypot(pose[at]!, pose[at + 1]!, pose[at + 2]!, pose[at + 3]!);
  const x = pose[at]! / length, y = pose[at + 1]! / length, z = pose[at + 2]! / length, w = pose[at + 3]! / length;
  // Rows and columns z, x, y of the rotation's matrix.
  const zz = 1 - 2 * (x * x + y * y), zx = 2 * (x * z - w * y), zy = 2 * (y * z + w * x);
  const xz = 2 * (x * z + w * y), xx = 1 - 2 * (y * y + z * z), xy = 2 * (x * y - w * z);
  const yz = 2 * (y * z - w * x), yx = 2 * (x * y + w * z), yy = 1 - 2 * (x * x + z * z);
  // b and c once a is known, from Rz(-a) R = Rx(b) Ry(c).
  const complete = (a: number) => {
    const cosine = Math.cos(a), sine = Math.sin(a);
    const b = Math.atan2(zy, cosine * yy - sine * xy);
    const c = Math.atan2(cosine * xz + sine * yz, cosine * xx + sine * yx);
    return [unwrap(a, near[0]!), unwrap(b, near[1]!), unwrap(c, near[2]!)];
  };
  const gimbal = Math.hypot(zz, zx) < GIMBAL;
  const a = gimbal ? near[0]! : Math.atan2(-xy, yy);
  const one = complete(a);
  if (first || gimbal) return one;
  const other = complete(a + Math.PI);
  return distance(one, near) <= distance(other, near) ? one : other;
}

const number = (value: number) => {
  const text = value.toFixed(6);
  return text === '-0.000000' ? '0.000000' : text;
};

// Unique names without blanks: most readers end a name at a blank.
function wordsOf(names: string[]): string[] {
  const taken = new Set<string>();
  return names.map((name, joint) => {
    let word = name.trim().replace(/[\s{}]+/g, '_') || `joint_${joint}`;
    while (taken.has(word)) word += '_';
    taken.add(word);
    return word;
  });
}

// The hierarchy, and its joints in depth-first order, which is the order of a motion row.
function hierarchyOf(body: Body): { text: string; order: number[] } {
  const names = wordsOf(body.names);
  const children: number[][] = body.names.map(() => []);
  body.parents.forEach((parent, joint) => children[parent]?.push(joint));
  const order: number[] = [];
  let text = 'HIERARCHY\n';
  const open: { joint: number; next: number }[] = [];
  const begin = (joint: number) => {
    const indent = '\t'.repeat(open.length);
    const offset = joint === 0 ? [0, 0, 0] : body.offsets.slice(3 * joint, 3 * joint + 3);
    const channels = joint === 0 ? '6 Xposition Yposition Zposition' : '3';
    text += `${indent}${joint === 0 ? 'ROOT' : 'JOINT'} ${names[joint]}\n${indent}{\n` +
      `${indent}\tOFFSET ${offset.map(number).join(' ')}\n` +
      `${indent}\tCHANNELS ${channels} Zrotation Xrotation Yrotation\n`;
    order.push(joint);
    open.push({ joint, next: 0 });
  };
  begin(0);
  while (open.length > 0) {
    const top = open.at(-1)!;
    const child = children[top.joint]![top.next++];
    if (child !== undefined) {
      begin(child);
      continue;
    }
    open.pop();
    const indent = '\t'.repeat(open.length);
    // Many readers require an End Site at the end of every chain.
    if (children[top.joint]!.length === 0) {
      text += `${indent}\tEnd Site\n${indent}\t{\n${indent}\t\tOFFSET 0.000000 0.000000 0.000000\n${indent}\t}\n`;
    }
    text += `${indent}}\n`;
  }
  return { text, order };
}

/** Yields the file in pieces, so that a long one need not be built at once. `frames`: number of poses. */
export function* bvhText(body: Body, rate_hz: number, frames: number, poses: Iterable<Pose>): Generator<string> {
  const { text, order } = hierarchyOf(body);
  yield `${text}MOTION\nFrames: ${frames}\nFrame Time: ${(1 / rate_hz).toFixed(9)}\n`;
  const angles = new Float64Array(3 * body.names.length);
  let rows = '', count = 0;
  for (const pose of poses) {
    const words = [number(pose[0]!), number(pose[1]!), number(pose[2]!)];
    for (const joint of order) {
      const near = angles.subarray(3 * joint, 3 * joint + 3);
      near.set(eulerOf(pose, 3 + 4 * joint, near, count === 0));
      for (const angle of near) words.push(number(angle * DEGREES));
    }
    rows += `${words.join(' ')}\n`;
    if (++count % ROWS === 0) {
      yield rows;
      rows = '';
    }
  }
  if (rows) yield rows;
}
