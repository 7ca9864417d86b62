// A body of round cones in one skinned mesh: each cone moves with the joint at its start.
import {
  Bone,
  BufferGeometry,
  Color,
  DetachedBindMode,
  Float32BufferAttribute,
  Group,
  Matrix4,
  MeshLambertMaterial,
  MeshStandardMaterial,
  Quaternion,
  Skeleton as Bones,
  SkinnedMesh,
  Uint16BufferAttribute,
  Vector3,
} from 'three';
import { makeTransforms, worldTransforms, type Frame } from 'styled-client';

import type { Line, Outline } from './flat.js';
import type { Part, Skeleton } from './skeleton.js';

/** Level of detail of bodies; lower with software rendering. */
export interface Detail {
  around: number; // vertices of a ring
  cap: number; // rings of a half sphere
}
export const FINE: Detail = { around: 20, cap: 5 };
export const COARSE: Detail = { around: 10, cap: 2 };
export const COARSEST: Detail = { around: 7, cap: 2 };

// Radii at both ends, and the ratio of depth to width; for a body of 1.5 m up to the head joint.
const SHAPES: Record<Part, [number, number, number]> = {
  hips: [0.118, 0.104, 0.8],
  spine: [0.108, 0.13, 0.76],
  chest: [0.136, 0.066, 0.8],
  neck: [0.05, 0.046, 1],
  head: [0.083, 0.096, 1.12],
  shoulder: [0.058, 0.06, 0.95],
  upperArm: [0.058, 0.041, 1],
  lowerArm: [0.043, 0.03, 1],
  hand: [0.036, 0.03, 0.55],
  upperLeg: [0.086, 0.058, 1],
  lowerLeg: [0.06, 0.038, 1],
  foot: [0.044, 0.042, 1],
  toes: [0.039, 0.03, 0.8],
  beyond: [0.012, 0.01, 1],
};
const SHADES: Partial<Record<Part, number>> = {
  hips: 0.72, spine: 0.94, chest: 1, neck: 0.86, head: 1.08, shoulder: 1, hand: 1.08,
  upperLeg: 0.9, lowerLeg: 0.9, foot: 0.72, toes: 0.72,
};
// Length beyond the last joint of a limb, in metres, for the same body.
const ENDS: Partial<Record<Part, number>> = { head: 0.12, hand: 0.11, toes: 0.05, foot: 0.1 };

class Shape {
  private readonly positions: number[] = [];
  private readonly normals: number[] = [];
  private readonly colors: number[] = [];
  private readonly owners: number[] = [];
  private readonly indices: number[] = [];

  constructor(private readonly detail: Detail) {}

  /** A round cone from `a` to `b`; `depth` scales it along `front`. */
  cone(a: Vector3, b: Vector3, ra: number, rb: number, depth: number, front: Vector3, joint: number,
       shade: number): void {
    const { around, cap } = this.detail;
    const axis = b.clone().sub(a);
    const length = axis.length();
    if (length > 1e-6) axis.divideScalar(length);
    else axis.set(0, 1, 0);
    const z = front.clone().addScaledVector(axis, -front.dot(axis));
    if (z.lengthSq() < 1e-4) z.set(1, 0, 0).addScaledVector(axis, -axis.x);
    if (z.lengthSq() < 1e-4) z.set(0, 0, 1);
    z.normalize();
    const x = new Vector3().crossVectors(axis, z);
    const first = this.positions.length / 3;
    const slope = length > 1e-6 ? (ra - rb) / length : 0;
    const rings: [number, number, number][] = []; // along, radius, normal along the axis
    for (let i = 0; i <= cap; ++i) {
      const angle = (Math.PI / 2) * (i / cap - 1);
      rings.push([Math.sin(angle) * ra, Math.max(0.001, Math.cos(angle) * ra), Math.sin(angle)]);
    }
    for (let i = 0; i <= cap; ++i) {
      const angle = (Math.PI / 2) * (i / cap);
      rings.push([length + Math.sin(angle) * rb, Math.max(0.001, Math.cos(angle) * rb), Math.sin(angle) || slope]);
    }
    rings[cap]![2] = slope;
    const at = new Vector3(), normal = new Vector3();
    for (const [along, radius, up] of rings) {
      const out = Math.sqrt(Math.max(0, 1 - up * up));
      for (let k = 0; k < around; ++k) {
        const angle = (2 * Math.PI * k) / around;
        const s = Math.sin(angle), c = Math.cos(angle);
        at.copy(a).addScaledVector(axis, along).addScaledVector(x, s * radius);
        at.addScaledVector(z, c * radius * depth);
        normal.copy(axis).multiplyScalar(up).addScaledVector(x, s * out);
        normal.addScaledVector(z, (c * out) / depth).normalize();
        this.positions.push(at.x, at.y, at.z);
        this.normals.push(normal.x, normal.y, normal.z);
        this.colors.push(shade, shade, shade);
        this.owners.push(joint);
      }
    }
    for (let ring = 0; ring + 1 < rings.length; ++ring) {
      for (let k = 0; k < around; ++k) {
        const p = first + ring * around + k, q = first + ring * around + ((k + 1) % around);
        this.indices.push(p, q, p + around, q, q + around, p + around);
      }
    }
  }

  build(): BufferGeometry {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute('normal', new Float32BufferAttribute(this.normals, 3));
    geometry.setAttribute('color', new Float32BufferAttribute(this.colors, 3));
    const skin = this.owners.flatMap((joint) => [joint, 0, 0, 0]);
    geometry.setAttribute('skinIndex', new Uint16BufferAttribute(skin, 4));
    const weights = this.owners.flatMap(() => [1, 0, 0, 0]);
    geometry.setAttribute('skinWeight', new Float32BufferAttribute(weights, 4));
    geometry.setIndex(this.indices);
    return geometry;
  }
}

// The T-pose as cones, in the scene's axes and in metres, so that radii do not depend on the rig's
// units.
function shapeOf(skeleton: Skeleton, detail: Detail): BufferGeometry {
  const shape = new Shape(detail);
  const { body, joints, rest, scene } = skeleton;
  const places = rest.map(({ position }) => position.clone().applyMatrix4(scene));
  const size = skeleton.height_m / 1.5;
  const ahead = new Vector3(0, 0, 1);
  const up = new Vector3(0, 1, 0);
  const children = body.names.map(() => 0);
  // Eyes, jaw and hair hang from a head that is drawn all the same.
  body.parents.forEach((parent, joint) => {
    const onHead = parent >= 0 && joints[parent]!.part === 'head' && joints[joint]!.part === 'beyond';
    if (parent >= 0 && !onHead) ++children[parent]!;
  });
  for (let joint = 0; joint < body.names.length; ++joint) {
    const { part } = joints[joint]!;
    const parent = body.parents[joint]!;
    const at = places[joint]!;
    if (parent >= 0) {
      const from = joints[parent]!.part;
      let [ra, rb, depth] = SHAPES[from];
      if (from === 'hips' && part === 'upperLeg') [ra, rb, depth] = [0.098, 0.088, 0.92];
      if (from === 'chest' && part === 'shoulder') [ra, rb, depth] = [0.08, 0.066, 0.85];
      if (from === 'chest' && part === 'chest') [ra, rb, depth] = [0.125, 0.13, 0.72];
      if (part === 'beyond' && from !== 'beyond') [ra, rb, depth] = [0.016, 0.012, 1];
      const shade = SHADES[from] ?? 0.92;
      if (from === 'shoulder' && part === 'upperArm') {
        // The volume between chest and arm.
        const trunk = body.parents[parent]!;
        const inner = trunk >= 0 ? places[trunk]!.clone().lerp(at, 0.42) : places[parent]!;
        inner.y += 0.2 * (at.y - inner.y);
        shape.cone(inner, at, 0.098 * size, 0.064 * size, 0.88, ahead, Math.max(trunk, 0), 1);
      }
      shape.cone(places[parent]!, at, ra * size, rb * size, depth, ahead, parent, shade);
    }
    const end = ENDS[part];
    if (children[joint] === 0 && end !== undefined) {
      const way = part === 'head' ? up : part === 'hand' && parent >= 0
        ? at.clone().sub(places[parent]!).normalize() : ahead;
      const [ra, rb, depth] = SHAPES[part];
      const to = at.clone().addScaledVector(way, end * size);
      const from = part === 'head' ? at.clone().addScaledVector(up, 0.045 * size) : at;
      shape.cone(from, to, ra * size, rb * size, depth, part === 'hand' ? up : ahead, joint, SHADES[part] ?? 1);
      if (part === 'head') {
        // The eyes, which show where the head faces.
        const eyes = from.clone().addScaledVector(up, 0.05 * size).addScaledVector(ahead, 0.084 * size);
        const aside = new Vector3(0.045 * size, 0, 0);
        shape.cone(eyes.clone().sub(aside), eyes.add(aside), 0.036 * size, 0.036 * size, 1, ahead, joint, 0.1);
      }
    }
    if (part === 'foot') {
      const heel = at.clone().addScaledVector(ahead, -0.035 * size).addScaledVector(up, -0.035 * size);
      shape.cone(at, heel, 0.042 * size, 0.034 * size, 1, ahead, joint, SHADES.foot!);
    }
  }
  return shape.build();
}

// Each vertex moves with one joint, so the shader reads one bone instead of four: with software
// rendering that is most of the cost of a body.
const ONE_BONE = {
  base: `#ifdef USE_SKINNING
    mat4 boneMatX = getBoneMatrix(skinIndex.x);
  #endif`,
  normal: `#ifdef USE_SKINNING
    objectNormal = (boneMatX * vec4(objectNormal, 0.0)).xyz;
  #endif`,
  vertex: `#ifdef USE_SKINNING
    transformed = (boneMatX * vec4(transformed, 1.0)).xyz;
  #endif`,
};

function bodyMaterial(detail: Detail): MeshStandardMaterial | MeshLambertMaterial {
  const material = detail === FINE
    ? new MeshStandardMaterial({ vertexColors: true, roughness: 0.62, metalness: 0.05 })
    : new MeshLambertMaterial({ vertexColors: true });
  material.onBeforeCompile = (shader) => {
    shader.vertexShader = shader.vertexShader
      .replace('#include <skinbase_vertex>', ONE_BONE.base)
      .replace('#include <skinnormal_vertex>', ONE_BONE.normal)
      .replace('#include <skinning_vertex>', ONE_BONE.vertex);
  };
  return material;
}

const THINNER = 0.7; // so that the limbs stay apart

// The same body as lines, for a picture without WebGL.
function linesOf({ body, joints, height_m }: Skeleton): Line[] {
  const size = height_m / 1.5;
  const lines: Line[] = [];
  body.parents.forEach((parent, joint) => {
    const { part } = joints[joint]!;
    if (part === 'head') {
      lines.push({ from: joint, to: joint, width_m: 2.1 * SHAPES.head[1] * size, shade: SHADES.head!, lift_m: 0.1 * size });
    }
    if (parent < 0) return;
    const from = joints[parent]!.part;
    if (from === 'head') return; // eyes, jaw and hair are within
    const [ra, rb] = part === 'beyond' ? SHAPES.beyond : SHAPES[from];
    lines.push({ from: parent, to: joint, width_m: THINNER * (ra + rb) * size, shade: SHADES[from] ?? 0.92 });
  });
  return lines;
}

export interface FigureLook {
  color: number;
  emissive?: number;
  opacity?: number;
}

/** One body on the stage. `group` is in the performer's world, in metres. */
export class Figure {
  readonly group = new Group();
  /** Joint positions of the last pose: 3*J, in metres, scene axes, the performer's world. */
  readonly joints: Float32Array;
  readonly left = new Vector3();
  readonly right = new Vector3();
  readonly hips = new Vector3();
  private readonly bones: Bone[];
  private lines: Line[] | undefined;
  private readonly mesh: SkinnedMesh;
  private readonly material;
  private readonly transforms;

  constructor(readonly skeleton: Skeleton, look: FigureLook, detail: Detail) {
    this.transforms = makeTransforms(skeleton.body);
    this.joints = new Float32Array(3 * skeleton.body.names.length);
    this.material = bodyMaterial(detail);
    this.setLook(look);
    // Bones are not in the scene graph: their matrices are written directly. Bind pose: scene from
    // joint in the T-pose.
    this.bones = skeleton.rest.map(() => new Bone());
    const inverses = skeleton.rest.map(({ position, rotation }) =>
      new Matrix4().compose(position, rotation, new Vector3(1, 1, 1)).premultiply(skeleton.scene).invert());
    this.mesh = new SkinnedMesh(shapeOf(skeleton, detail), this.material);
    this.mesh.bindMode = DetachedBindMode;
    this.mesh.bind(new Bones(this.bones, inverses), new Matrix4());
    this.mesh.frustumCulled = false;
    this.group.add(this.mesh);
  }

  setLook({ color, emissive = 0, opacity = 1 }: FigureLook): void {
    this.material.color.set(color);
    this.material.emissive = new Color(emissive);
    const transparent = opacity < 1;
    if (this.material.transparent !== transparent) this.material.needsUpdate = true;
    this.material.transparent = transparent;
    this.material.opacity = opacity;
    this.material.depthWrite = true;
  }

  setPose(frame: Frame): void {
    const { positions, rotations } = worldTransforms(this.skeleton.body, frame, this.transforms);
    const position = new Vector3(), rotation = new Quaternion(), one = new Vector3(1, 1, 1);
    this.bones.forEach((bone, joint) => {
      position.fromArray(positions, 3 * joint);
      rotation.fromArray(rotations, 4 * joint);
      bone.matrixWorld.compose(position, rotation, one).premultiply(this.skeleton.scene);
      position.setFromMatrixPosition(bone.matrixWorld).toArray(this.joints, 3 * joint);
    });
    const { leftFoot, rightFoot } = this.skeleton;
    this.hips.fromArray(this.joints);
    if (leftFoot >= 0) this.left.fromArray(this.joints, 3 * leftFoot);
    if (rightFoot >= 0) this.right.fromArray(this.joints, 3 * rightFoot);
  }

  /** The head's joint in the scene; undefined if the rig has none. */
  head(): Vector3 | undefined {
    const { head } = this.skeleton;
    return head < 0 ? undefined : this.group.localToWorld(new Vector3().fromArray(this.joints, 3 * head));
  }

  /** The body as lines; the joints are those of the last pose. */
  get outline(): Outline {
    const { color, opacity } = this.material;
    this.lines ??= linesOf(this.skeleton);
    return { points: this.joints, at: this.group.matrixWorld, lines: this.lines, color: color.getHex(), opacity };
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.material.dispose();
    this.mesh.skeleton.dispose();
    this.group.removeFromParent();
  }
}
