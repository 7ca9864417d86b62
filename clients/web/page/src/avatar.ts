// A VRM avatar that shows a styled body. VRM's normalized humanoid has the canonical humanoid's
// joints, axes and rest pose, so rotations are copied unchanged; the hips' position is scaled by
// hips height.
import { Group, LoadingManager, Quaternion, Vector3 } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { VRMLoaderPlugin, VRMUtils, type VRM, type VRMHumanBoneName } from '@pixiv/three-vrm';
import type { Body, Frame } from 'styled-client';

import { unreadable, vrmFault } from './vrm_file.js';

const MAX_BYTES = 256 << 20;

export class Avatar {
  readonly group = new Group();
  /** A pose has arrived, so the avatar may be shown. */
  ready = false;
  private readonly turn: number; // VRM 0 looks along -Z

  private constructor(
    readonly name: string,
    private readonly vrm: VRM,
    /** Textures of the file that could not be loaded; their surfaces are drawn without them. */
    readonly lostPictures: number,
  ) {
    this.turn = vrm.meta?.metaVersion === '0' ? -1 : 1;
    VRMUtils.rotateVRM0(vrm);
    vrm.scene.traverse((object) => (object.frustumCulled = false));
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
    const rotation = new Quaternion();
    body.names.forEach((name, joint) => {
      const bone = humanoid.getNormalizedBoneNode(name as VRMHumanBoneName);
      if (!bone) return;
      rotation.fromArray(frame.rotations, 4 * joint).normalize();
      if (this.turn < 0) rotation.set(-rotation.x, rotation.y, -rotation.z, rotation.w);
      bone.quaternion.copy(rotation);
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
    this.ready = true;
    this.group.visible = true;
  }

  draw(dt_s: number): void {
    this.vrm.update(Math.min(dt_s, 0.1));
  }

  /** Position of a humanoid bone in the scene. */
  place(bone: VRMHumanBoneName): Vector3 | undefined {
    return this.vrm.humanoid.getRawBoneNode(bone)?.getWorldPosition(new Vector3());
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
