// Synthetic bodies and motion, and BVH read by three.js, which is independent of the page's writer.
import { create } from '@bufbuild/protobuf';
import { Vector3 } from 'three';
import { BVHLoader } from 'three/examples/jsm/loaders/BVHLoader.js';
import { BodySchema, FrameSchema, Output } from 'styled-client';

export function randomOf(seed) {
  let state = seed;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

/** A body whose joints are not in depth-first order, in metres. */
export function makeBody(fields = {}) {
  const parents = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 3];
  const random = randomOf(7);
  return create(BodySchema, {
    performer: 'rig.a', names: parents.map((_, joint) => `joint${joint}`), parents,
    offsets: [0.1, 0.95, -0.2, ...Array.from({ length: 3 * (parents.length - 1) }, () => random() - 0.5)],
    metresPerUnit: 1, hash: 7n, output: Output.RIG, ...fields,
  });
}

export function makeFrame(body, sequence, fields = {}) {
  return create(FrameSchema, {
    performer: 'rig.a', epoch: 1n, sequence: BigInt(sequence), bodyHash: body.hash, output: Output.RIG,
    sourceTimeNs: BigInt(Math.round(sequence * 1e9 / 120)), receiveTimeNs: BigInt(5e9 + Math.round(sequence * 1e9 / 120)),
    rootPosition: [0, 1, 0], rotations: body.names.flatMap(() => [0, 0, 0, 1]), ...fields,
  });
}

/** The quaternion of a rotation about an axis of any length. */
export function turn([x, y, z], angle) {
  const s = Math.sin(angle / 2) / Math.hypot(x, y, z);
  return [x * s, y * s, z * s, Math.cos(angle / 2)];
}

/** Reads the file: a joint's world position in a frame, the number of frames, their step. */
export function readBvh(text) {
  const { skeleton, clip } = new BVHLoader().parse(text);
  const bones = skeleton.bones.filter(({ name }) => name !== 'ENDSITE');
  const tracks = clip.tracks; // position and quaternion of each bone, in order
  const { times } = tracks[0];
  return {
    names: bones.map(({ name }) => name),
    frames: times.length,
    times,
    positions(frame) {
      bones.forEach((bone, i) => {
        bone.position.fromArray(tracks[2 * i].values, 3 * frame);
        bone.quaternion.fromArray(tracks[2 * i + 1].values, 4 * frame);
      });
      bones[0].updateMatrixWorld(true);
      return new Map(bones.map((bone) => [bone.name, new Vector3().setFromMatrixPosition(bone.matrixWorld).toArray()]));
    },
  };
}
