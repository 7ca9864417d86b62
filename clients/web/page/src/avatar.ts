// A VRM avatar that shows a styled body and a face. VRM's normalized humanoid has the canonical
// humanoid's joints, axes and rest pose, so rotations are copied unchanged; the hips' position is
// scaled by hips height. Joints go by name: fingers, eyes and jaw move where both have them.
import { Group, LoadingManager, Quaternion, Vector3, type Object3D } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { VRMLoaderPlugin, VRMLookAtBoneApplier, VRMUtils, type VRM, type VRMHumanBoneName } from '@pixiv/three-vrm';
import type { Body, Frame } from 'styled-client';

import { expressionsOf } from './expressions.js';
import { unreadable, vrmFault } from './vrm_file.js';

const MAX_BYTES = 256 << 20;
const LOOK_DEG = 30; // of an eye, where an expression says that it looks aside, up or down in full
const LOOKS = ['lookUp', 'lookDown', 'lookLeft', 'lookRight'];

export class Avatar {
  readonly group = new Group();
  /** A pose has arrived, so the avatar may be shown. */
  ready = false;
  private readonly turn: number; // VRM 0 looks along -Z
  private body: Body | undefined; // of the last pose
  private moving = new Set<string>(); // expressions that are not 0
  private readonly expressions: string[];

  private constructor(
    readonly name: string,
    private readonly vrm: VRM,
    /** Textures of the file that could not be loaded; their surfaces are drawn without them. */
    readonly lostPictures: number,
  ) {
    this.turn = vrm.meta?.metaVersion === '0' ? -1 : 1;
    VRMUtils.rotateVRM0(vrm);
    vrm.scene.traverse((object) => (object.frustumCulled = false));
    this.expressions = Object.keys(vrm.expressionManager?.expressionMap ?? {});
    vrm.update(0); // looks straight ahead once, which would undo the first pose's eyes
    this.group.add(vrm.scene);
    this.group.visible = false;
  }

  /** The error states what is wrong with the file. */
  static async load(file: File): Promise<Avatar> {
    if (file.size > MAX_BYTES) throw new Error(`${file.name} is too large; expected at most 256 MiB`);
    const bytes = await file.arrayBuffer();
    const fault = vrmFault(file.name, bytes);
    if (fault) throw new Error(fault);
    const lost = new Set<string>();
    const manager = new LoadingManager();
    manager.onError = (url) => lost.add(url);
    const loader = new GLTFLoader(manager);
    loader.register((parser) => new VRMLoaderPlugin(parser));
    let vrm: VRM | undefined;
    try {
      const gltf = await loader.parseAsync(bytes, '');
      vrm = gltf.userData.vrm as VRM | undefined;
      if (vrm) VRMUtils.removeUnnecessaryVertices(gltf.scene);
    } catch (error) {
      throw new Error(unreadable(file.name, error));
    }
    if (!vrm) throw new Error(unreadable(file.name, 'no VRM came of it'));
    return new Avatar(file.name, vrm, lost.size);
  }

  setPose(body: Body, frame: Frame): void {
    const { humanoid } = this.vrm;
    if (body !== this.body) humanoid.resetNormalizedPose(); // the other one may have had fingers
    this.body = body;
    const rotations: Quaternion[] = []; // from the nearest joint above that the avatar has
    const bones = body.names.map((name) => humanoid.getNormalizedBoneNode(name as VRMHumanBoneName));
    bones.forEach((bone, joint) => {
      const rotation = new Quaternion().fromArray(frame.rotations, 4 * joint).normalize();
      if (this.turn < 0) rotation.set(-rotation.x, rotation.y, -rotation.z, rotation.w);
      const parent = body.parents[joint]!;
      if (parent >= 0 && !bones[parent]) rotation.premultiply(rotations[parent]!);
      rotations.push(rotation);
      bone?.quaternion.copy(rotation);
    });
    const hips = humanoid.getNormalizedBoneNode('hips');
    if (hips) {
      // The body at rest stands on its feet: Body.offsets contains the height of the hips.
      const scale = (humanoid.normalizedRestPose.hips?.position?.[1] ?? 1) / restHeight(body);
      const [x, y, z] = frame.rootPosition as [number, number, number];
      // Horizontally the avatar follows the performer without scaling.
      hips.position.set(0, y * scale, 0);
      this.group.position.set(x, 0, z);
    }
    this.setFace(frame, bones.some((bone, joint) => bone && /^(left|right)Eye$/.test(body.names[joint]!)));
    this.ready = true;
    this.group.visible = true;
  }

  // `eyes`: the pose turns them.
  private setFace(frame: Frame, eyes: boolean): void {
    const { expressionManager: manager, lookAt } = this.vrm;
    const byBones = lookAt && !eyes && lookAt.applier instanceof VRMLookAtBoneApplier;
    const values = expressionsOf(frame.expressions, byBones ? [...this.expressions, ...LOOKS] : this.expressions, eyes);
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

  /** The next pose has nothing to do with the last one: hair and cloth hang at rest. */
  rewind(): void {
    this.vrm.springBoneManager?.reset();
  }

  draw(dt_s: number): void {
    this.vrm.update(Math.min(dt_s, 0.1));
  }

  /** Position of a humanoid bone in the scene. */
  place(bone: VRMHumanBoneName): Vector3 | undefined {
    return this.vrm.humanoid.getRawBoneNode(bone)?.getWorldPosition(new Vector3());
  }

  /** A bone as the avatar's file has it; for tests. */
  bone(name: VRMHumanBoneName): Object3D | null {
    return this.vrm.humanoid.getRawBoneNode(name);
  }

  /** The avatar's expressions that are not 0; for tests. */
  get face(): Map<string, number> {
    return new Map([...this.moving].map((name) => [name, this.vrm.expressionManager?.getValue(name) ?? 0]));
  }

  dispose(): void {
    VRMUtils.deepDispose(this.vrm.scene);
  }
}

// Height of the hips above the soles: joint 0's offset is its position at rest.
function restHeight(body: Body): number {
  const height = body.offsets[1]!;
  return height > 0.1 ? height : 1;
}
