// A VRM avatar from a file, which shows a styled body and a face as the client library poses it.
import { Group, LoadingManager, Vector3, type Object3D } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { VRMLoaderPlugin, VRMUtils, type VRM, type VRMHumanBoneName } from '@pixiv/three-vrm';
import type { Body, Frame } from 'styled-client';
import { VrmPoser } from 'styled-client/three-vrm';

import { unreadable, vrmFault } from './vrm_file.js';

const MAX_BYTES = 256 << 20;

export class Avatar {
  readonly group = new Group();
  /** A pose has arrived, so the avatar may be shown. */
  ready = false;
  private readonly poser: VrmPoser;

  private constructor(
    readonly name: string,
    private readonly vrm: VRM,
    /** Textures of the file that could not be loaded; their surfaces are drawn without them. */
    readonly lostPictures: number,
  ) {
    VRMUtils.rotateVRM0(vrm);
    vrm.scene.traverse((object) => (object.frustumCulled = false));
    this.poser = new VrmPoser(vrm, this.group);
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
    this.poser.pose(body, frame);
    this.ready = true;
    this.group.visible = true;
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
    return this.poser.expressions;
  }

  dispose(): void {
    VRMUtils.deepDispose(this.vrm.scene);
  }
}
