// Writes a take as glTF binary of the avatar that was worn: the avatar's own file, with an animation in
// front of its own ones. Meshes, skins, textures and extensions (VRM) stay byte for byte as they are.
// Pinned by test/avatar_glb.test.mjs, in which independent programs read it.
import { Matrix4, Quaternion, Vector3, type Group, type Object3D } from 'three';

import type { Avatar } from './avatar.js';
import { GlbWriter, openGlb, type GltfNode, type Path } from './glb.js';
import type { Replay } from './replay.js';
import { Column, everyFrame } from './sampled.js';

const AT_REST = 1e-6; // tolerance of a rotation's numbers, not visible

/** The moving parts of an avatar, by node of its file. */
export interface Nodes {
  bones: Map<number, Object3D>;
  /** Weights of morph targets. */
  faces: Map<number, number[]>;
  hips: Object3D;
}

// The hips' translation in the file, if the hips walk over the floor. On the stage `floor` does.
function hipsOf(hips: Object3D, floor: Group): [number, number, number] {
  floor.updateWorldMatrix(true, false);
  hips.parent!.updateWorldMatrix(true, false);
  const floorFromParent = new Matrix4().copy(floor.matrixWorld).invert().multiply(hips.parent!.matrixWorld);
  const place = hips.position.clone().applyMatrix4(floorFromParent);
  place.x += floor.position.x;
  place.z += floor.position.z;
  return place.applyMatrix4(floorFromParent.invert()).toArray();
}

// glTF animates no matrices.
function partsOf(node: GltfNode): void {
  if (!node.matrix) return;
  const place = new Vector3(), rotation = new Quaternion(), scale = new Vector3();
  new Matrix4().fromArray(node.matrix).decompose(place, rotation, scale);
  delete node.matrix;
  Object.assign(node, { translation: place.toArray(), rotation: rotation.toArray(), scale: scale.toArray() });
}

/** `replay` has the canonical humanoid. The avatar may be worn meanwhile: the stage shows the live pose.
Rejects if its file can no longer be read. */
export async function avatarGlb(replay: Replay, avatar: Avatar): Promise<Blob> {
  const { gltf, buffer } = openGlb(await avatar.file.arrayBuffer());
  const { frames, take: { performer } } = replay;
  const { bones, faces, hips } = avatar.posed();
  const way = new Column(3, frames);
  const turns = [...bones].map(([node, bone]) => ({ node, bone, column: new Column(4, frames) }));
  const weights = [...faces].map(([node, values]) => ({ node, values, column: new Column(values.length, frames) }));
  const times = await everyFrame(replay, ({ body, frame }) => {
    avatar.pose(body, frame);
    way.add(hipsOf(hips, avatar.group));
    for (const { bone, column } of turns) column.addRotation(bone.quaternion.toArray());
    for (const { values, column } of weights) column.add(values);
  }, () => avatar.resume());
  const channels: [number, Path, Float32Array][] = [];
  for (const { node, bone, column } of turns) {
    const own = gltf.nodes![node]!;
    partsOf(own);
    if (bone === hips) channels.push([node, 'translation', way.values]);
    if (!column.stays(own.rotation ?? [0, 0, 0, 1], AT_REST)) channels.push([node, 'rotation', column.values]);
  }
  for (const { node, values, column } of weights) {
    if (!column.stays(values.map(() => 0), 0)) channels.push([node, 'weights', column.values]);
  }
  const scene = gltf.scenes?.[gltf.scene ?? 0];
  if (scene) scene.name = performer;
  const writer = new GlbWriter(gltf, buffer);
  writer.animation(performer, times, channels);
  return writer.file();
}
