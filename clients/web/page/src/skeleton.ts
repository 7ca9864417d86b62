// Identifies a rig's joints and axes. A Body contains neither axes nor handedness, but its T-pose
// determines them: up is from the feet to the head, left from the right arm to the left one, and
// forward is where the toes point.
import { Matrix4, Quaternion, Vector3 } from 'three';
import { Output, type Body } from 'styled-client';

export type Part =
  | 'hips' | 'spine' | 'chest' | 'neck' | 'head'
  | 'shoulder' | 'upperArm' | 'lowerArm' | 'hand'
  | 'upperLeg' | 'lowerLeg' | 'foot' | 'toes' | 'beyond';

export interface Joint {
  part: Part;
  side: 'left' | 'right' | '';
}

export interface Skeleton {
  body: Body;
  joints: Joint[];
  /** Scene from body: metres, +Y up, +Z forward, +X the body's left. */
  scene: Matrix4;
  /** The T-pose in the body's own units and axes. */
  rest: { position: Vector3; rotation: Quaternion }[];
  height_m: number;
  head: number;
  leftFoot: number;
  rightFoot: number;
}

const PARTS: [RegExp, Part][] = [
  [/thumb|index|middle|ring|pinky|little|finger|eye|jaw|twist|breast|hair/, 'beyond'],
  [/hand|wrist/, 'hand'],
  [/fore|lower_?arm|elbow/, 'lowerArm'],
  [/shoulder|clav|collar/, 'shoulder'],
  [/arm/, 'upperArm'],
  [/toe|ball/, 'toes'],
  [/foot|ankle/, 'foot'],
  [/lower_?leg|calf|shin|knee/, 'lowerLeg'],
  [/up_?leg|upper_?leg|thigh|(left|right|l|r)_?hip/, 'upperLeg'],
  [/leg/, 'lowerLeg'],
  [/head/, 'head'],
  [/neck/, 'neck'],
  [/chest|thorax|spine_?[1-9]/, 'chest'],
  [/spine|torso|waist|abdomen/, 'spine'],
  [/hip|pelvis|root/, 'hips'],
];

function jointOf(name: string): Joint {
  const plain = name.split(':').pop()!.replace(/([a-z])([A-Z])/g, '$1_$2').toLowerCase();
  const part = PARTS.find(([pattern]) => pattern.test(plain))?.[1] ?? 'beyond';
  const side = /left|(^|_)l(_|$)/.test(plain) ? 'left' : /right|(^|_)r(_|$)/.test(plain) ? 'right' : '';
  return { part, side };
}

function restOf(body: Body): Skeleton['rest'] {
  const rest: Skeleton['rest'] = [];
  for (let joint = 0; joint < body.names.length; ++joint) {
    const rotation = new Quaternion();
    if (body.rest.length > 0) rotation.fromArray(body.rest, 4 * joint).normalize();
    const position = new Vector3().fromArray(body.offsets, 3 * joint);
    const parent = rest[body.parents[joint]!];
    if (parent) position.applyQuaternion(parent.rotation).add(parent.position);
    rest.push({ position, rotation });
  }
  return rest;
}

/** The signed axis nearest to `v`. */
function axisOf(v: Vector3): Vector3 {
  const [x, y, z] = [Math.abs(v.x), Math.abs(v.y), Math.abs(v.z)];
  if (y >= x && y >= z) return new Vector3(0, Math.sign(v.y) || 1, 0);
  return x >= z ? new Vector3(Math.sign(v.x), 0, 0) : new Vector3(0, 0, Math.sign(v.z));
}

export function skeletonOf(body: Body): Skeleton {
  const joints = body.names.map(jointOf);
  const rest = restOf(body);
  const find = (part: Part, side: Joint['side']) =>
    joints.findIndex((joint) => joint.part === part && joint.side === side);
  const place = (part: Part, side: Joint['side'] = '') => rest[find(part, side)]?.position;
  const between = (from: Vector3 | undefined, to: Vector3 | undefined) =>
    from && to ? to.clone().sub(from) : undefined;

  const leftFoot = find('foot', 'left');
  const rightFoot = find('foot', 'right');
  const upward = between(place('foot', 'left') ?? place('hips'), place('head') ?? place('neck'));
  const up = axisOf(upward ?? new Vector3(0, 1, 0));
  const across = (v: Vector3) => v.addScaledVector(up, -v.dot(up));
  const leftward =
    between(place('hand', 'right'), place('hand', 'left')) ??
    between(place('upperLeg', 'right'), place('upperLeg', 'left')) ??
    new Vector3(1, 0, 0);
  const left = axisOf(across(leftward));
  const ahead = new Vector3().crossVectors(left, up);
  const toes = between(place('foot', 'left'), place('toes', 'left'));
  if (toes && toes.dot(ahead) < -0.2 * toes.length()) ahead.negate(); // left-handed: mirrored here

  let unit_m = body.metresPerUnit;
  const tall = upward ? Math.abs(upward.dot(up)) : 0;
  if (!(unit_m > 0)) unit_m = tall > 0 ? 1.5 / tall : 1;
  const scene = new Matrix4();
  if (body.output !== Output.CANONICAL) {
    scene.set(
      left.x, left.y, left.z, 0,
      up.x, up.y, up.z, 0,
      ahead.x, ahead.y, ahead.z, 0,
      0, 0, 0, 1,
    );
  }
  scene.premultiply(new Matrix4().makeScale(unit_m, unit_m, unit_m));
  return { body, joints, scene, rest, height_m: tall > 0 ? tall * unit_m : 1.5, head: find('head', ''), leftFoot, rightFoot };
}
