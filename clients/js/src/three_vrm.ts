// Poses an avatar of @pixiv/three-vrm by frames of the canonical stream. The only source that needs three
// and @pixiv/three-vrm, hence its own entry point: 'styled-client/three-vrm'.
import { VRMLookAtBoneApplier, type VRM, type VRMHumanBoneName } from '@pixiv/three-vrm';
import { Quaternion, type Object3D } from 'three';

import { expressionsOf } from './expressions.js';
import type { Body } from './gen/proto/styled/v1/body_pb.js';
import type { Frame } from './gen/proto/styled/v1/frame_pb.js';

const LOOK_DEG = 30; // of an eye, for an expression that looks fully aside, up or down
const LOOKS = ['lookUp', 'lookDown', 'lookLeft', 'lookRight'];

/** The part of a frame that poses an avatar. */
export type Pose = Pick<Frame, 'rootPosition' | 'rotations' | 'expressions'>;

/** Poses one VRM, of version 0 or 1. VRM's normalized humanoid has the canonical humanoid's joints, axes
and rest pose, so rotations are copied unchanged, by joint name. Fingers, eyes and jaw move if both have
them; the rotation of a joint that the avatar lacks is added to the next one below. The hips' height is
scaled to the avatar's; over the floor it follows the performer, in metres. Expressions are matched by
name, too (VRM 0's, 1.0's, ARKit's). Call `vrm.update(dt)` afterwards, as
without this. */
export class VrmPoser {
  private readonly turn: number; // VRM 0 looks along -Z
  private readonly own: string[];
  private body: Body | undefined; // of the last pose; by its joints:
  private bones: (Object3D | null)[] = [];
  private rotations: Quaternion[] = []; // from the nearest joint above that the avatar has
  private eyes = false; // the body turns the avatar's eyes
  private moving = new Set<string>();

  /** `vrm`: for version 0, call VRMUtils.rotateVRM0(vrm) yourself if it should look along +Z. `floor`: the
  object that moves over the floor, by its position's x and z; by default the avatar's scene. */
  constructor(
    private readonly vrm: VRM,
    private readonly floor: Object3D = vrm.scene,
  ) {
    this.turn = vrm.meta?.metaVersion === '0' ? -1 : 1;
    this.own = Object.keys(vrm.expressionManager?.expressionMap ?? {});
    vrm.update(0); // looks straight ahead once, which would undo the first pose's eyes
  }

  /**
   * `body` and `frame` are of an Update of the canonical stream. They must belong together; the client has
   * checked them. This call does not.
   */
  pose(body: Body, frame: Pose): void {
    const { humanoid } = this.vrm;
    if (body !== this.body) this.take(body);
    const { bones, rotations } = this;
    bones.forEach((bone, joint) => {
      const rotation = rotations[joint]!.fromArray(frame.rotations, 4 * joint).normalize();
      if (this.turn < 0) rotation.set(-rotation.x, rotation.y, -rotation.z, rotation.w);
      const parent = body.parents[joint]!;
      if (parent >= 0 && !bones[parent]) rotation.premultiply(rotations[parent]!);
      bone?.quaternion.copy(rotation);
    });
    const hips = humanoid.getNormalizedBoneNode('hips');
    if (hips) {
      const scale = (humanoid.normalizedRestPose.hips?.position?.[1] ?? 1) / restHeight(body);
      const [x, y, z] = frame.rootPosition as [number, number, number];
      hips.position.set(0, y * scale, 0);
      this.floor.position.x = x;
      this.floor.position.z = z;
    }
    this.setFace(frame);
  }

  /** The avatar's expressions that the last pose set, by the avatar's names; none is 0. */
  get expressions(): Map<string, number> {
    return new Map([...this.moving].map((name) => [name, this.vrm.expressionManager?.getValue(name) ?? 0]));
  }

  private take(body: Body): void {
    const { humanoid } = this.vrm;
    humanoid.resetNormalizedPose(); // the other body may have had fingers
    this.body = body;
    this.bones = body.names.map((name) => humanoid.getNormalizedBoneNode(name as VRMHumanBoneName));
    this.rotations = body.names.map(() => new Quaternion());
    this.eyes = this.bones.some((bone, joint) => bone && /^(left|right)Eye$/.test(body.names[joint]!));
  }

  private setFace(frame: Pose): void {
    const { eyes } = this;
    const { expressionManager: manager, lookAt } = this.vrm;
    const byBones = lookAt && !eyes && lookAt.applier instanceof VRMLookAtBoneApplier;
    const values = expressionsOf(frame.expressions, byBones ? [...this.own, ...LOOKS] : this.own, eyes);
    if (byBones) {
      const [up, down, left, right] = LOOKS.map((name) => values.get(name) ?? 0) as [number, number, number, number];
      const yaw = LOOK_DEG * (left - right), pitch = LOOK_DEG * (down - up);
      if (yaw !== lookAt.yaw) lookAt.yaw = yaw;
      if (pitch !== lookAt.pitch) lookAt.pitch = pitch;
      for (const name of LOOKS) values.delete(name);
    }
    for (const name of this.moving) if (!values.has(name)) manager?.setValue(name, 0);
    for (const [name, value] of values) manager?.setValue(name, value);
    this.moving = new Set(values.keys());
  }
}

// Height of the hips above the soles: the body at rest stands on its feet, and joint 0's offset is its
// position at rest.
function restHeight(body: Body): number {
  const height = body.offsets[1]!;
  return height > 0.1 ? height : 1;
}
