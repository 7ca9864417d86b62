// VRM animations of takes, read by the Khronos validator, three.js and three-vrm-animation. VRMA_SAMPLES: a
// folder for a file and where its joints are, for gltf_read_back (tests/witness/gltf).
import assert from 'node:assert/strict';
import { mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { VRMAnimationLoaderPlugin, VRMLookAtQuaternionProxy, createVRMAnimationClip } from '@pixiv/three-vrm-animation';
import { VRMLoaderPlugin } from '@pixiv/three-vrm';
import { AnimationMixer, Quaternion, Vector3 } from 'three';
import { worldTransforms } from 'styled-client';
import { VrmPoser } from 'styled-client/three-vrm';

import { makeAvatar } from './avatar.mjs';
import { vrmaOf } from './dist/vrma.js';
import { frameOf, humanoid, replayOf } from './humanoid.mjs';
import { load, player, validBytes } from './read_glb.mjs';

const FRAMES = 90;
const whole = humanoid(), plain = humanoid({ tail: false });
const animated = (parser) => new VRMAnimationLoaderPlugin(parser);
const face = (i) => ({ expressions: [['Joy', i / 100], ['blink_l', 2], ['LookUp', 0.5], ['eyeBlinkLeft', 0.25], ['tongueOut', NaN]]
  .map(([name, value]) => ({ name, value })) });
const places = (body, frame) => {
  const { positions } = worldTransforms(body, frame);
  return body.names.map((_, joint) => new Vector3().fromArray(positions, 3 * joint));
};

test('every joint is where our own forward kinematics has it, within 0.1 mm, in every frame', async () => {
  for (const body of [plain, whole]) {
    const gltf = await load(await validBytes(await vrmaOf(replayOf(body, FRAMES))));
    const at = player(gltf);
    let worst = 0, next = 0;
    for (let i = 0; i < FRAMES; ++i) {
      const place = at(i / 60);
      const [now, later] = [i, i + 1].map((i) => places(body, frameOf(body, i)));
      body.names.forEach((name, joint) => {
        if (/Eye$/.test(name)) return;
        const found = place(gltf.scene.getObjectByName(name));
        worst = Math.max(worst, found.distanceTo(now[joint]));
        next = Math.max(next, found.distanceTo(later[joint]));
      });
    }
    assert.ok(worst < 1e-4, `${worst} m`);
    assert.ok(next > 0.01, `a frame beside it is as near: ${next} m`);
  }
});

test('bones, true height of the hips, presets, other expressions and gaze are found by three-vrm-animation', async () => {
  const bytes = await validBytes(await vrmaOf(replayOf(whole, FRAMES, face)));
  const { userData: { vrmAnimations: [found] } } = await load(bytes, animated);
  const { humanoidTracks: { rotation, translation }, expressionTracks: { preset, custom } } = found;
  assert.deepEqual([...rotation.keys()].sort(), whole.names.filter((name) => !/Eye$/.test(name)).sort());
  assert.deepEqual([...translation.keys()], ['hips']);
  assert.ok(Math.abs(found.restHipsPosition.y - 0.98) < 1e-6);
  assert.ok(Math.abs(found.duration - (FRAMES - 1) / 60) < 1e-5);
  assert.deepEqual([[...preset.keys()], [...custom.keys()]], [['happy', 'blinkLeft'], ['eyeBlinkLeft', 'tongueOut']]);
  const last = ({ values }) => Math.round(1000 * values.at(-1)) / 1000;
  assert.deepEqual([...preset.values(), ...custom.values()].map(last), [0.89, 1, 0.25, 0]);
  const json = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 20, new DataView(bytes).getUint32(12, true))));
  assert.deepEqual([json.scenes[0].name, json.animations[0].name], ['rig.a', 'rig.a']);
  assert.deepEqual(json.extensions.VRMC_vrm_animation.lookAt.offsetFromHeadBone.map((x) => Math.round(1000 * x)), [0, 60, 80]);
  const eyes = ['leftEye', 'rightEye'].map((eye) => whole.names.indexOf(eye));
  for (const i of [0, 40, FRAMES - 1]) {
    const { rotations } = frameOf(whole, i);
    const [left, right] = eyes.map((joint) => new Quaternion().fromArray(rotations, 4 * joint));
    const gaze = new Quaternion().fromArray(found.lookAtTrack.values, 4 * i);
    assert.ok(gaze.angleTo(left.slerp(right, 0.5)) < 1e-3, `frame ${i}`);
  }
});

test('without eyes there is no gaze, without a face there are no expressions', async () => {
  const { userData: { vrmAnimations: [found] } } = await load(await validBytes(await vrmaOf(replayOf(plain, 10))), animated);
  assert.equal(found.lookAtTrack, null);
  assert.equal(found.expressionTracks.preset.size + found.expressionTracks.custom.size, 0);
});

test('an avatar that three-vrm-animation moves stands as the one that the page moves', async () => {
  // The boxes have neither shoulders nor toes, and who has not those does not show them: here they rest.
  const resting = (i) => ({ rotations: frameOf(whole, i).rotations.map((value, k) =>
    (/Shoulder|Toes|Thumb/.test(whole.names[Math.floor(k / 4)]) ? Number(k % 4 === 3) : value)) });
  const avatars = await Promise.all([0, 1].map(async () => {
    const bytes = makeAvatar(undefined, { details: true });
    const { userData } = await load(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), (parser) => new VRMLoaderPlugin(parser));
    return userData.vrm;
  }));
  const { userData: { vrmAnimations: [animation] } } = await load(await validBytes(await vrmaOf(replayOf(whole, FRAMES, resting))), animated);
  const [other, own] = avatars;
  const proxy = new VRMLookAtQuaternionProxy(other.lookAt);
  proxy.name = 'gaze';
  other.scene.add(proxy);
  const mixer = new AnimationMixer(other.scene);
  mixer.clipAction(createVRMAnimationClip(animation, other)).play();
  const poser = new VrmPoser(own);
  let worst = 0;
  for (let i = 0; i + 1 < FRAMES; ++i) {
    mixer.setTime(i / 60);
    poser.pose(whole, frameOf(whole, i, resting(i)));
    for (const vrm of avatars) vrm.update(0);
    const place = (vrm, name) => vrm.humanoid.getRawBoneNode(name)?.getWorldPosition(new Vector3()).sub(vrm.humanoid.getRawBoneNode('hips').getWorldPosition(new Vector3()));
    for (const name of whole.names) {
      if (!/Eye$/.test(name) && place(own, name)) worst = Math.max(worst, place(own, name).distanceTo(place(other, name)));
    }
  }
  assert.ok(worst < 1e-3, `${worst} m`);
});

test('a file for the reader of clips in C++', { skip: !process.env.VRMA_SAMPLES }, async () => {
  const folder = process.env.VRMA_SAMPLES;
  mkdirSync(folder, { recursive: true });
  writeFileSync(path.join(folder, 'page.vrma'), Buffer.from(await validBytes(await vrmaOf(replayOf(whole, FRAMES, face)))));
  const times = Array.from({ length: FRAMES }, (_, i) => i / 60);
  writeFileSync(path.join(folder, 'expected.json'), JSON.stringify({
    times, metres: times.map((_, i) => places(whole, frameOf(whole, i)).slice(0, plain.names.length).map((place) => place.toArray())),
  }));
});
