// A VRM avatar of boxes, posed by frames with fingers, eyes and expressions; without a browser.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Output } from 'styled-client';

import { makeAvatar } from './avatar.mjs';
import { Avatar } from './dist/avatar.js';
import { FINE } from './dist/figure.js';
import { PerformerOnStage } from './dist/performer.js';
import { makeBody, makeFrame, turn } from './support.mjs';

const PRESETS = ['happy', 'aa', 'blink', 'blinkLeft', 'blinkRight'];
const load = (options) => Avatar.load(new File([makeAvatar(undefined, options)], 'boxes.vrm'));

const TRUNK = [['hips', -1], ['spine', 0], ['chest', 1], ['upperChest', 2], ['leftShoulder', 3], ['leftUpperArm', 4],
  ['leftLowerArm', 5], ['leftHand', 6], ['neck', 3], ['head', 8]];
const TAIL = [['leftIndexProximal', 7], ['leftIndexIntermediate', 10], ['leftEye', 9], ['rightEye', 9], ['jaw', 9], ['tongue', 14]];

function bodyOf(bones) {
  return makeBody({
    names: bones.map(([name]) => name), parents: bones.map(([, parent]) => parent), output: Output.CANONICAL,
    offsets: [0, 0.9, 0, ...bones.slice(1).flatMap(() => [0, 0.1, 0])],
  });
}
/** All joints at rest, except for these: degrees about X. */
function frameOf(body, turned = {}, fields = {}) {
  const rotations = body.names.flatMap((name) => turn([1, 0, 0], ((turned[name] ?? 0) * Math.PI) / 180));
  return makeFrame(body, 1, { rotations, rootPosition: [0, 0.9, 0], output: Output.CANONICAL, ...fields });
}
/** Degrees about X of the avatar's bone, against its parent bone. */
function degrees(avatar, bone) {
  const { x, w } = avatar.bone(bone).quaternion;
  return (2 * Math.atan2(x, w) * 180) / Math.PI;
}
const near = (found, expected) => assert.ok(Math.abs(found - expected) < 0.01, `${found}, expected ${expected}`);

test('fingers, eyes and jaw move as the body says, by name', async () => {
  const avatar = await load({ details: true });
  const body = bodyOf([...TRUNK, ...TAIL]);
  avatar.setPose(body, frameOf(body, { leftHand: 20, leftIndexProximal: 70, leftIndexIntermediate: 30, leftEye: 10, jaw: 15 }));
  avatar.draw(0.01);
  for (const [bone, angle] of [['leftHand', 20], ['leftIndexProximal', 70], ['leftIndexIntermediate', 30], ['leftEye', 10],
    ['rightEye', 0], ['jaw', 15]]) near(degrees(avatar, bone), angle);
});

test('a body without fingers leaves them at rest, also after one that had some', async () => {
  const avatar = await load({ details: true });
  const [whole, plain] = [bodyOf([...TRUNK, ...TAIL]), bodyOf(TRUNK)];
  avatar.setPose(whole, frameOf(whole, { leftIndexProximal: 70, jaw: 15 }));
  avatar.setPose(plain, frameOf(plain, { leftHand: 20 }));
  avatar.draw(0.01);
  for (const [bone, angle] of [['leftHand', 20], ['leftIndexProximal', 0], ['jaw', 0]]) near(degrees(avatar, bone), angle);
});

test('what a joint does that the avatar has not, the next one below does', async () => {
  const avatar = await load({});
  const body = bodyOf([...TRUNK, ...TAIL]);
  avatar.setPose(body, frameOf(body, { upperChest: 10, leftShoulder: 5, leftUpperArm: 20, neck: 3 }));
  avatar.draw(0.01);
  near(degrees(avatar, 'leftUpperArm'), 35);
  near(degrees(avatar, 'neck'), 13);
});

test('expressions come and go; eyes look by bones unless the pose turns them', async () => {
  const avatar = await load({ details: true, presets: PRESETS, customs: ['tailWag'] });
  const face = (...values) => ({ expressions: values.map(([name, value]) => ({ name, value })) });
  const plain = bodyOf(TRUNK), whole = bodyOf([...TRUNK, ...TAIL]);
  avatar.setPose(plain, frameOf(plain, {}, face(['Joy', 0.5], ['Blink_L', 1], ['TAILWAG', 0.25], ['LookUp', 1])));
  avatar.draw(0.01);
  assert.deepEqual(Object.fromEntries(avatar.face), { happy: 0.5, blinkLeft: 1, tailWag: 0.25 });
  assert.ok(degrees(avatar, 'leftEye') < -2, 'looks up');
  avatar.setPose(plain, frameOf(plain));
  avatar.draw(0.01);
  assert.equal(avatar.face.size, 0);
  near(degrees(avatar, 'leftEye'), 0);
  avatar.setPose(whole, frameOf(whole, { leftEye: 12 }, face(['LookUp', 1])));
  avatar.draw(0.01);
  near(degrees(avatar, 'leftEye'), 12);
});

test('an avatar without a face is no error', async () => {
  const avatar = await load({});
  const body = bodyOf(TRUNK);
  avatar.setPose(body, frameOf(body, {}, { expressions: [{ name: 'Joy', value: 1 }, { name: 'jawOpen', value: 1 }] }));
  avatar.draw(0.01);
  assert.equal(avatar.face.size, 0);
});

test('an avatar that is taken off outlives its performer; one that is worn does not', async () => {
  const avatar = await load();
  let disposed = 0;
  avatar.group.traverse(({ geometry }) => geometry?.addEventListener('dispose', () => ++disposed));
  const client = { subscribeLatest: () => () => {} };
  const [first, second] = ['rig.a', 'rig.b'].map((name) => new PerformerOnStage(name, client, FINE));
  first.setAvatar(avatar);
  assert.equal(first.takeOff(), avatar);
  assert.equal(first.avatar, undefined);
  first.dispose();
  assert.equal(disposed, 0);
  second.setAvatar(avatar);
  assert.equal(second.avatar, avatar);
  second.dispose();
  assert.ok(disposed > 0);
});

test('an avatar stays on its floor, however far the performer goes and whatever its size', async () => {
  const avatar = await load();
  const updates = {};
  const client = { subscribeLatest: () => () => {}, latest: (_, stream) => updates[stream] };
  const performer = new PerformerOnStage('rig.a', client, FINE);
  performer.setAvatar(avatar);
  const rig = makeBody(), canonical = bodyOf(TRUNK);
  let sequence = 0;
  const walk = (seconds) => {
    for (const end = sequence + 120 * seconds; sequence < end; ++sequence) {
      const way_m = sequence / 120;
      for (const stream of ['source', 'rig']) updates[stream] = { body: rig, frame: makeFrame(rig, sequence, { rootPosition: [way_m, 1, 0] }) };
      updates.canonical = { body: canonical, frame: frameOf(canonical, {}, { rootPosition: [0.8 * way_m, 0.9, 0] }) };
      performer.take();
      performer.draw({ overlay: false, trails: true, contacts: true, alone: true, props: false }, true, 1 / 120);
    }
    performer.group.updateMatrixWorld(true);
    return avatar.place('hips');
  };
  for (const seconds of [1, 19]) assert.ok(Math.abs(walk(seconds).x) < 0.2, `${avatar.place('hips').x} m from its floor after ${sequence / 120} m`);
  // Another avatar, in the middle of the way.
  const other = await load();
  performer.setAvatar(other);
  sequence += 1;
  walk(1 / 120);
  assert.ok(Math.abs(other.place('hips').x) < 0.2);
  performer.dispose();
});
