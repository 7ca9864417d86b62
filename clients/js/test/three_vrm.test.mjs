// A VRM of boxes is posed by canonical frames, in Node; and a VRM 0, which looks the other way. The page's
// use of the same class is tested in clients/web/page/test/avatar.test.mjs.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { create, fromBinary } from '@bufbuild/protobuf';
import { VRMLoaderPlugin } from '@pixiv/three-vrm';
import { BodySchema, FrameSchema, worldTransforms } from 'styled-client';
import { VrmPoser } from 'styled-client/three-vrm';
import { Group, Quaternion, Vector3 } from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

import { makeAvatar } from '../../web/page/test/avatar.mjs';

const HIPS_M = 0.7; // of the avatar of boxes

async function load(options) {
  const loader = new GLTFLoader();
  loader.register((parser) => new VRMLoaderPlugin(parser));
  const bytes = makeAvatar(undefined, options);
  const { vrm } = (await loader.parseAsync(new Uint8Array(bytes).buffer, '')).userData;
  return vrm;
}

const BONES = [['hips', -1], ['spine', 0], ['chest', 1], ['neck', 2], ['head', 3], ['jaw', 4], ['halo', 4],
  ['leftUpperArm', 2], ['leftLowerArm', 7], ['leftHand', 8], ['leftIndexProximal', 9]];
const body = create(BodySchema, {
  names: BONES.map(([name]) => name), parents: BONES.map(([, parent]) => parent),
  offsets: [0, 1.4, 0, ...BONES.slice(1).flatMap(() => [0, 0.1, 0])], hash: 5n, output: 2,
});
function makeFrame(turned = {}, fields = {}) {
  const rotations = body.names.flatMap((name) => turned[name] ?? [0, 0, 0, 1]);
  return create(FrameSchema, { bodyHash: 5n, output: 2, rootPosition: [3, 1.2, -2], rotations, ...fields });
}
const about = (axis, degrees) =>
  axis.map((x) => x * Math.sin((degrees * Math.PI) / 360)).concat(Math.cos((degrees * Math.PI) / 360));
const close = (found, expected, what) =>
  expected.forEach((value, i) => assert.ok(Math.abs(found[i] - value) < 1e-5, `${what}: ${[...found]} is not ${expected}`));

test('joints turn by name, in steps that both have; the hips are as high as theirs', async () => {
  const vrm = await load({ details: true });
  const poser = new VrmPoser(vrm);
  poser.pose(body, makeFrame({
    leftHand: about([0, 0, 1], 20), leftIndexProximal: about([1, 0, 0], 60).map((x) => 3 * x), jaw: about([1, 0, 0], 15),
  }));
  vrm.update(0.01);
  const turn = (bone) => vrm.humanoid.getRawBoneNode(bone).quaternion.toArray();
  close(turn('leftHand'), about([0, 0, 1], 20), 'hand');
  close(turn('leftIndexProximal'), about([1, 0, 0], 60), 'a finger, of a quaternion of length 3');
  close(turn('jaw'), about([1, 0, 0], 15), 'jaw');
  const hips = vrm.humanoid.getRawBoneNode('hips').getWorldPosition(new Vector3());
  close(hips.toArray(), [3, 1.2 * HIPS_M / 1.4, -2], 'hips');
});

test('another object may be moved over the floor', async () => {
  const vrm = await load({});
  const stage = new Group();
  stage.add(vrm.scene);
  stage.position.y = 5;
  new VrmPoser(vrm, stage).pose(body, makeFrame());
  assert.deepEqual([...stage.position, ...vrm.scene.position], [3, 5, -2, 0, 0, 0]);
});

test('a VRM 0, turned about, does the same in the world', async () => {
  const pose = makeFrame({ hips: about([0, 1, 0], 30), leftUpperArm: about([0.6, 0, 0.8], 40), leftLowerArm: about([0, 1, 0], 50) });
  const hands = [];
  for (const version of ['1', '0']) {
    const vrm = await load({});
    if (version === '0') {
      vrm.meta = { metaVersion: '0' };
      vrm.scene.rotation.y = Math.PI; // VRMUtils.rotateVRM0
    }
    new VrmPoser(vrm).pose(body, pose);
    vrm.update(0.01);
    vrm.scene.updateMatrixWorld(true);
    hands.push(vrm.humanoid.getRawBoneNode('leftHand').getWorldQuaternion(new Quaternion()));
  }
  // In the file of a VRM 0 the left hand is where its bones face -Z: a half turn before the pose.
  const [one, zero] = hands;
  assert.ok(Math.abs(zero.multiply(new Quaternion(0, 1, 0, 0)).dot(one)) > 1 - 1e-6);
});

test('expressions come and go by name', async () => {
  const vrm = await load({ presets: ['happy', 'aa'], customs: ['tailWag'] });
  const poser = new VrmPoser(vrm);
  const face = (...values) => makeFrame({}, { expressions: values.map(([name, value]) => ({ name, value })) });
  poser.pose(body, face(['Joy', 0.5], ['A', 2], ['TailWag', 0.25], ['unknown', 1]));
  assert.deepEqual(Object.fromEntries(poser.expressions), { happy: 0.5, aa: 1, tailWag: 0.25 });
  poser.pose(body, face(['Joy', NaN]));
  assert.equal(poser.expressions.size, 0);
  assert.equal(vrm.expressionManager.getValue('happy'), 0);
});

const folder = process.env.STYLED_GOLDENS;
test('a frame of the real daemon turns each bone as the canonical body', { skip: folder ? false : 'STYLED_GOLDENS is not set' }, async () => {
  const golden = JSON.parse(readFileSync(path.join(folder, 'canonical.json'), 'utf8'));
  const bytes = (hex) => new Uint8Array(Buffer.from(hex, 'hex'));
  const real = fromBinary(BodySchema, bytes(golden.body));
  const vrm = await load({});
  const poser = new VrmPoser(vrm);
  for (const entry of golden.frames) {
    const frame = fromBinary(FrameSchema, bytes(entry.frame));
    poser.pose(real, frame);
    vrm.update(0.01);
    vrm.scene.updateMatrixWorld(true);
    const { rotations } = worldTransforms(real, frame);
    for (const bone of ['hips', 'head', 'leftHand', 'rightFoot']) {
      const joint = real.names.indexOf(bone);
      const turn = vrm.humanoid.getRawBoneNode(bone).getWorldQuaternion(new Quaternion());
      const dot = turn.dot(new Quaternion().fromArray(rotations, 4 * joint));
      assert.ok(Math.abs(dot) > 1 - 1e-5, `${bone}: ${dot}`);
    }
  }
});
