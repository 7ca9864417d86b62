// A VRM avatar from a file, posed by the client library with a styled body and a face.
import { Box3, Group, LoadingManager, Vector3, type Mesh, type Object3D } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { VRMLoaderPlugin, VRMUtils, type VRM, type VRMHumanBoneName } from '@pixiv/three-vrm';
import type { Body, Frame } from 'styled-client';
import { VrmPoser, type Pose } from 'styled-client/three-vrm';

import type { Nodes } from './avatar_glb.js';
import { unreadable, vrmFault } from './vrm_file.js';

const MAX_BYTES = 256 << 20;

export class Avatar {
  readonly group = new Group();
  /** A pose has arrived, so the avatar may be shown. */
  ready = false;
  /** From the head's joint to the top of the avatar, hair included, as it stands. */
  readonly crown_m: number;
  private readonly poser: VrmPoser;
  private shown: { body: Body; frame: Pose } | undefined;

  private constructor(
    /** As it was loaded. */
    readonly file: File,
    private readonly vrm: VRM,
    private readonly nodes: ReadonlyMap<Object3D, number>,
    /** Textures of the file that could not be loaded; their surfaces are drawn without them. */
    readonly lostPictures: number,
  ) {
    VRMUtils.rotateVRM0(vrm);
    vrm.scene.traverse((object) => (object.frustumCulled = false));
    this.poser = new VrmPoser(vrm, this.group);
    this.group.add(vrm.scene);
    const crown = new Box3().setFromObject(vrm.scene).max.y;
    this.crown_m = Math.max(0.05, crown - (this.place('head')?.y ?? crown));
    this.group.visible = false;
  }

  get name(): string {
    return this.file.name;
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
    const nodes = new Map<Object3D, number>();
    try {
      const gltf = await loader.parseAsync(bytes, '');
      vrm = gltf.userData.vrm as VRM | undefined;
      // parser.associations cannot be used: nodes that share a mesh share their entry there.
      const objects = (await gltf.parser.getDependencies('node')) as Object3D[];
      objects.forEach((object, node) => nodes.set(object, node));
      if (vrm) VRMUtils.removeUnnecessaryVertices(gltf.scene);
    } catch (error) {
      throw new Error(unreadable(file.name, error));
    }
    if (!vrm) throw new Error(unreadable(file.name, 'the file contains no VRM'));
    return new Avatar(file, vrm, nodes, lost.size);
  }

  setPose(body: Body, frame: Frame): void {
    this.poser.pose(body, frame);
    this.shown = { body, frame };
    this.ready = true;
    this.group.visible = true;
  }

  /** The parts that poses move, with their nodes in the file; hair and cloth, which springs move, are
  excluded. */
  posed(): Nodes {
    const { humanoid, nodeConstraintManager } = this.vrm;
    const node = (object: Object3D) => this.nodes.get(object);
    const bones = new Map<number, Object3D>(), faces = new Map<number, number[]>();
    const turned = [...Object.keys(humanoid.humanBones).map((name) => humanoid.getRawBoneNode(name as VRMHumanBoneName)),
                    ...[...(nodeConstraintManager?.constraints ?? [])].map(({ destination }) => destination)];
    for (const bone of turned) {
      const at = bone ? node(bone) : undefined;
      if (bone && at !== undefined) bones.set(at, bone);
    }
    this.vrm.scene.traverse((object) => {
      const { morphTargetInfluences } = object as Mesh;
      // A mesh of several primitives is a group in three, which has the node.
      const at = node(object) ?? (object.parent ? node(object.parent) : undefined);
      if (morphTargetInfluences && morphTargetInfluences.length > 0 && at !== undefined) faces.set(at, morphTargetInfluences);
    });
    return { bones, faces, hips: humanoid.getRawBoneNode('hips')! };
  }

  /** Sets a pose for readers of `posed`, until `resume`; springs are not updated. */
  pose(body: Body, frame: Pose): void {
    this.poser.pose(body, frame);
    this.vrm.update(0);
  }
  /** Back to the pose of setPose. */
  resume(): void {
    if (this.shown) this.pose(this.shown.body, this.shown.frame);
  }

  /** The next pose is unrelated to the last one: hair and cloth hang at rest. */
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
