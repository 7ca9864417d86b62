// Files of glTF, read by programs that are not ours: the Khronos validator, three.js.
import assert from 'node:assert/strict';
import validator from 'gltf-validator';
import { AnimationMixer, Vector3 } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

globalThis.self = globalThis; // three's loader of textures asks for it

/** The file's bytes, in which the validator finds neither errors nor warnings, except for these `known` codes. */
export async function validBytes(blob, ...known) {
  const bytes = await blob.arrayBuffer();
  const { issues } = await validator.validateBytes(new Uint8Array(bytes));
  assert.deepEqual(issues.messages.filter(({ severity, code }) => severity < 2 && !known.includes(code)), []);
  return bytes;
}

/** The scene that three.js loads. `plugins`: of its loader. */
export function load(bytes, ...plugins) {
  const loader = new GLTFLoader();
  for (const plugin of plugins) loader.register(plugin);
  return loader.parseAsync(bytes, '');
}

/** Shows the first animation at a time; the function returns a node's place. */
export function player({ scene, animations: [clip] }) {
  const mixer = new AnimationMixer(scene);
  mixer.clipAction(clip).play();
  return (time_s) => {
    mixer.setTime(Math.min(time_s, clip.duration - 1e-9)); // it would restart at its end
    scene.updateMatrixWorld(true);
    return (object) => object.getWorldPosition(new Vector3());
  };
}
