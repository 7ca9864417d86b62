// The exports of stylerec and stylize, read by other projects' programs: the Khronos glTF validator and three.js's
// loaders. Each joint must be where expected.json has it, which the project's forward kinematics computed from
// the recorded poses.  node witness.mjs FOLDER (walk.glb, walk30.glb, worn.glb, walk.vrma,
// walk.bvh, expected.json)
import fs from 'node:fs';
import path from 'node:path';
import validator from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { BVHLoader } from 'three/examples/jsm/loaders/BVHLoader.js';

import { VRMAnimationLoaderPlugin } from '@pixiv/three-vrm-animation';
import { GLTFExporter } from 'three/examples/jsm/exporters/GLTFExporter.js';

globalThis.self = globalThis;
// The globals that three.js's exporter needs of a browser.
globalThis.FileReader = class {
  readAsArrayBuffer(blob) {
    blob.arrayBuffer().then((buffer) => {
      this.result = buffer;
      this.onloadend();
    });
  }
};
const folder = process.argv[2];
const read = (name) => fs.readFileSync(path.join(folder, name));
const expected = JSON.parse(read('expected.json'));
let failed = false;

function check(condition, text) {
  console.log(`${condition ? 'ok' : 'FAILED'}: ${text}`);
  failed ||= !condition;
}

// The largest distance of a joint from its expected place, at the expected times.
function worst(root, clip, places, positions) {
  const mixer = new THREE.AnimationMixer(root);
  mixer.clipAction(clip).play();
  let most = 0;
  const place = new THREE.Vector3();
  expected.times.forEach((time, k) => {
    mixer.setTime(time);
    root.updateMatrixWorld(true);
    expected.names.forEach((name, joint) => {
      places(name).getWorldPosition(place);
      most = Math.max(most, place.distanceTo(new THREE.Vector3(...positions[k][joint])));
    });
  });
  return most;
}

for (const name of ['walk.glb', 'walk30.glb']) {
  const bytes = read(name);
  const report = await validator.validateBytes(new Uint8Array(bytes));
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  check(numErrors + numWarnings + numInfos + numHints === 0,
        `${name}: the validator has nothing to say ${JSON.stringify(messages)}`);
  check(report.info.generator === 'styled', `${name}: made by styled`);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await new Promise((done, fail) => new GLTFLoader().parse(buffer, '', done, fail));
  const most_m = worst(gltf.scene, gltf.animations[0], (joint) => gltf.scene.getObjectByName(joint),
                       expected.metres);
  check(most_m < 1e-4, `${name}: joints are within ${most_m} m`);
  // As three.js writes it, for gltf_read_back. Its exporter writes the nodes' current pose.
  const { scene, animations } = (await new Promise((done, fail) =>
    new GLTFLoader().parse(buffer.slice(0), '', done, fail)));
  const written = await new Promise((done, fail) =>
    new GLTFExporter().parse(scene, done, fail, { binary: true, animations }));
  fs.writeFileSync(path.join(folder, `three-${name}`), Buffer.from(written));
  let mesh;
  gltf.scene.traverse((object) => { if (object.isSkinnedMesh) mesh = object; });
  check(mesh?.skeleton.bones.length === expected.names.length, `${name}: a skin of all joints`);
  // The skinned mesh moves with the figure: its hips bone begins at the hips.
  mesh.skeleton.update();
  const corner = new THREE.Vector3().fromBufferAttribute(mesh.geometry.attributes.position, 0);
  mesh.applyBoneTransform(0, corner).applyMatrix4(mesh.matrixWorld);
  const last = expected.metres.at(-1)[0];
  check(corner.distanceTo(new THREE.Vector3(...last)) < 1e-4, `${name}: the mesh is where the hips are`);
}

// An avatar with a motion that stylize added: the same figure, so the same places.
{
  const bytes = read('worn.glb');
  const report = await validator.validateBytes(new Uint8Array(bytes));
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  check(numErrors + numWarnings + numInfos + numHints === 0,
        `worn.glb: the validator has nothing to say ${JSON.stringify(messages)}`);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const gltf = await new Promise((done, fail) => new GLTFLoader().parse(buffer, '', done, fail));
  check(gltf.animations.length === 2 && gltf.animations[0].name === 'walk',
        'worn.glb: the motion is the first of two animations');
  const most_m = worst(gltf.scene, gltf.animations[0], (joint) => gltf.scene.getObjectByName(joint),
                       expected.metres);
  check(most_m < 0.02, `worn.glb: joints are within ${most_m} m`);
  let mesh;
  gltf.scene.traverse((object) => { if (object.isSkinnedMesh) mesh = object; });
  check(mesh?.skeleton.bones.length === expected.names.length, 'worn.glb: the mesh and its skin are there');
}

// A VRM animation that stylize wrote of the same motion, read by the library that moves VRM avatars.
{
  const bytes = read('walk.vrma');
  const report = await validator.validateBytes(new Uint8Array(bytes));
  const { numErrors, numWarnings, messages } = report.issues;
  check(numErrors + numWarnings === 0, `walk.vrma: the validator warns of nothing ${JSON.stringify(messages)}`);
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMAnimationLoaderPlugin(parser));
  const { scene, animations, userData: { vrmAnimations } } =
    await new Promise((done, fail) => loader.parse(buffer, '', done, fail));
  const { rotation, translation } = vrmAnimations[0].humanoidTracks;
  check(expected.names.every((name) => rotation.has(name)) && rotation.size === expected.names.length,
        'walk.vrma: a track of each bone of the humanoid');
  check(translation.size === 1 && translation.has('hips'), 'walk.vrma: the hips alone move');
  check(Math.abs(vrmAnimations[0].restHipsPosition.y - 0.98) < 1e-6, 'walk.vrma: the hips rest at their height');
  const most_m = worst(scene, animations[0], (joint) => scene.getObjectByName(joint), expected.metres);
  check(most_m < 0.01, `walk.vrma: joints are within ${most_m} m`);
}

const bvh = new BVHLoader().parse(read('walk.bvh').toString());
const most_units = worst(bvh.skeleton.bones[0], bvh.clip,
                         (joint) => bvh.skeleton.bones.find((bone) => bone.name === joint),
                         expected.units);
check(most_units < 0.01, `walk.bvh: joints are within ${most_units} units`);
process.exit(failed ? 1 : 0);
