// Reads BVH with three.js, and computes a frame's joint positions, both independently of the page's
// code.
import { Quaternion, Vector3 } from 'three';
import { BVHLoader } from 'three/examples/jsm/loaders/BVHLoader.js';

export function readBvh(text) {
  const { skeleton, clip } = new BVHLoader().parse(text);
  const bones = skeleton.bones.filter(({ name }) => name !== 'ENDSITE');
  const { times } = clip.tracks[0]; // then position and quaternion of each bone, in order
  return {
    frames: times.length,
    frameTime_s: times.at(-1) / (times.length - 1),
    /** Name -> world position, in a frame. */
    positions(frame) {
      bones.forEach((bone, i) => {
        bone.position.fromArray(clip.tracks[2 * i].values, 3 * frame);
        bone.quaternion.fromArray(clip.tracks[2 * i + 1].values, 4 * frame);
      });
      bones[0].updateMatrixWorld(true);
      return new Map(bones.map((bone) => [bone.name, new Vector3().setFromMatrixPosition(bone.matrixWorld).toArray()]));
    },
  };
}

export function worldPositions({ parents, offsets }, root, rotations) {
  const joints = [];
  parents.forEach((parent, joint) => {
    const rotation = new Quaternion().fromArray(rotations, 4 * joint).normalize();
    const position = new Vector3().fromArray(joint === 0 ? root : offsets.slice(3 * joint, 3 * joint + 3));
    if (joint > 0) {
      position.applyQuaternion(joints[parent].rotation).add(joints[parent].position);
      rotation.premultiply(joints[parent].rotation);
    }
    joints.push({ position, rotation });
  });
  return joints.map(({ position }) => position.toArray());
}
