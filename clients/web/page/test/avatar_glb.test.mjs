// An avatar's file with a take as its animation, read by the Khronos validator and three.js.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { VRMLoaderPlugin } from '@pixiv/three-vrm';
import { Vector3 } from 'three';

import { makeAvatar } from './avatar.mjs';
import { avatarGlb } from './dist/avatar_glb.js';
import { Avatar } from './dist/avatar.js';
import { GlbWriter, openGlb } from './dist/glb.js';
import { frameOf, humanoid, replayOf } from './humanoid.mjs';
import { load, player, validBytes } from './read_glb.mjs';

const FRAMES = 60;
// The smallest PNG: one pixel.
const PICTURE = Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR4nGNgYGBgAAAABQABpfZFQAAAAABJRU5ErkJggg==', 'base64');
const body = humanoid();
const BONES = body.names.filter((name) => !/Toes|Shoulder|Thumb/.test(name));
const face = (i) => ({ expressions: [{ name: 'Joy', value: i / FRAMES }, { name: 'blink', value: 1 }] });

const whole = (buffer) => buffer.buffer.slice(buffer.byteOffset, buffer.byteOffset + buffer.length);

/** The avatar's file with morph targets, and what `change` does to its description. */
async function avatarFile(change = () => {}) {
  const made = makeAvatar(PICTURE, { details: true, presets: ['happy', 'blink'] });
  const { gltf, buffer } = openGlb(whole(made));
  const writer = new GlbWriter(gltf, buffer.slice());
  const add = (values, width, fields) => {
    const at = writer.accessor(values, 'SCALAR');
    Object.assign(gltf.accessors[at], { count: 8, type: `VEC${width}`, ...fields });
    return at;
  };
  const attributes = { ...gltf.meshes[0].primitives[0].attributes, TEXCOORD_0: add(new Float32Array(16), 2) };
  gltf.meshes[0].primitives[0].attributes = attributes;
  const nudge = writer.accessor(new Float32Array(24).fill(0.01), 'VEC3');
  Object.assign(gltf.accessors[nudge], { min: [0.01, 0.01, 0.01].map(Math.fround), max: [0.01, 0.01, 0.01].map(Math.fround) });
  gltf.meshes.push({ ...gltf.meshes[0], primitives: gltf.meshes[0].primitives.map((one) => ({ ...one, targets: [{ POSITION: nudge }, { POSITION: nudge }] })) });
  // A box that hangs on the hips by a skin.
  const weights = new Float32Array(32).map((_, i) => Number(i % 4 === 0));
  gltf.meshes.push({ primitives: [{ ...gltf.meshes[0].primitives[0], attributes: { ...attributes,
    JOINTS_0: add(new Float32Array(16), 4, { componentType: 5123 }), WEIGHTS_0: add(weights, 4) } }] });
  gltf.skins = [{ joints: [0] }];
  gltf.nodes.push({ name: 'skinned', mesh: 2, skin: 0 });
  gltf.scenes[0].nodes.push(gltf.nodes.length - 1);
  const head = gltf.nodes.findIndex(({ name }) => name === 'head');
  gltf.nodes[head].mesh = 1;
  const { preset } = gltf.extensions.VRMC_vrm.expressions;
  preset.happy = { morphTargetBinds: [{ node: head, index: 0, weight: 0.5 }] };
  preset.blink = { morphTargetBinds: [{ node: head, index: 1, weight: 1 }] };
  change(gltf);
  return new Uint8Array(await writer.file().arrayBuffer());
}

// The file's hips hang from a moved and turned node, and have a matrix.
function turned(gltf) {
  const [hips] = gltf.nodes;
  const [x, y, z] = hips.translation;
  delete hips.translation;
  // A quarter turn about X, and back; the node is 0.3 m behind.
  hips.matrix = [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, x, z + 0.3, -y, 1];
  gltf.nodes.push({ name: 'Armature', translation: [0, 0, -0.3], rotation: [Math.SQRT1_2, 0, 0, Math.SQRT1_2], children: [0] });
  gltf.scenes[0].nodes[0] = gltf.nodes.length - 1;
}

// The same avatar as VRM 0: it looks along -Z, and states it by other keys.
function asVrm0(gltf) {
  for (const node of gltf.nodes) {
    const [x, y, z] = node.translation ?? [0, 0, 0];
    node.translation = [-x, y, -z];
  }
  const { humanBones } = gltf.extensions.VRMC_vrm.humanoid;
  gltf.extensionsUsed = ['VRM'];
  gltf.extensions = { VRM: {
    specVersion: '0.0', exporterVersion: 'the test', meta: { title: 'Boxes', author: 'the test' },
    humanoid: { humanBones: Object.entries(humanBones).map(([bone, { node }]) => ({ bone, node, useDefaultValues: true })) },
    blendShapeMaster: { blendShapeGroups: [
      { name: 'Joy', presetName: 'joy', binds: [{ mesh: 1, index: 0, weight: 50 }] },
      { name: 'Blink', presetName: 'blink', binds: [{ mesh: 1, index: 1, weight: 100 }] }] },
    firstPerson: {}, secondaryAnimation: { boneGroups: [], colliderGroups: [] }, materialProperties: [],
  } };
}

for (const [name, change] of [['VRM 1.0', undefined], ['VRM 1.0 under a turned node, with a matrix', turned], ['VRM 0', asVrm0]]) {
  test(`${name}: bones and face are those of the page, in every frame; the file keeps what it has`, async () => {
    const file = await avatarFile(change);
    const avatar = await Avatar.load(new File([file], 'boxes.vrm'));
    const live = frameOf(body, 500);
    avatar.setPose(body, live);
    avatar.draw(0.01);
    const before = avatar.place('leftHand');
    const bytes = await validBytes(await avatarGlb(replayOf(body, FRAMES, face), avatar), 'INVALID_EXTENSION_NAME_FORMAT'); // of VRM 0
    avatar.draw(0.01);
    assert.ok(avatar.place('leftHand').distanceTo(before) < 1e-6, 'the stage shows what is live');

    const [old, now] = [whole(file), bytes].map(openGlb);
    assert.ok(Buffer.from(now.buffer.subarray(0, old.buffer.length)).equals(Buffer.from(old.buffer)), 'meshes and pictures');
    for (const what of ['meshes', 'skins', 'materials', 'textures', 'images', 'extensions', 'extensionsUsed']) assert.deepEqual(now.gltf[what], old.gltf[what]);
    assert.deepEqual([now.gltf.scenes[0].name, now.gltf.animations.map(({ name }) => name)], ['rig.a', ['rig.a']]);

    const gltf = await load(bytes, (parser) => new VRMLoaderPlugin(parser));
    const { vrm } = gltf.userData;
    const head = gltf.scene.getObjectByName('head');
    const at = player(gltf);
    // On the stage VRM 0 is turned round, so that it looks along +Z, as the performer does.
    const turn = vrm.meta.metaVersion === '0' ? -1 : 1;
    let worst = 0, beside = 0;
    for (let i = 0; i < FRAMES; ++i) {
      const place = at(i / 60);
      const placesOf = (i) => {
        avatar.pose(body, frameOf(body, i, face(i)));
        avatar.group.updateMatrixWorld(true);
        return BONES.map((bone) => avatar.place(bone).multiply(new Vector3(turn, 1, turn)));
      };
      const next = placesOf(i + 1), wanted = placesOf(i);
      BONES.forEach((bone, k) => {
        const found = place(vrm.humanoid.getRawBoneNode(bone));
        worst = Math.max(worst, found.distanceTo(wanted[k]));
        beside = Math.max(beside, found.distanceTo(next[k]));
      });
      const [happy, blink] = head.morphTargetInfluences;
      assert.ok(Math.abs(happy - (0.5 * i) / FRAMES) < 1e-3 && blink === 1, `face of frame ${i}: ${happy}, ${blink}`);
    }
    assert.ok(worst < 1e-3, `${worst} m`);
    assert.ok(beside > 0.01, `a frame beside it is as near: ${beside} m`);
  });
}

test('animations that the avatar has come after the take; a bone that stays at rest gets no channel', async () => {
  const avatar = await Avatar.load(new File([await avatarFile()], 'boxes.vrm'));
  const once = openGlb(await validBytes(await avatarGlb(replayOf(body, 10), avatar)));
  const again = await Avatar.load(new File([await validBytes(await avatarGlb(replayOf(body, 10), avatar))], 'again.vrm'));
  const { gltf } = openGlb(await validBytes(await avatarGlb(replayOf(body, 20), again)));
  assert.equal(gltf.animations.length, 2);
  assert.deepEqual(gltf.animations[1].channels, once.gltf.animations[0].channels);
  const still = humanoid({ tail: false });
  const { gltf: less } = openGlb(await validBytes(await avatarGlb(replayOf(still, 10), avatar)));
  const channels = ({ animations: [{ channels }] }) => channels.map(({ target: { node } }) => less.nodes[node].name);
  assert.ok(channels(once.gltf).includes('leftIndexProximal') && !channels(less).includes('leftIndexProximal'));
});

test('a file that has changed since is said so', async () => {
  const avatar = await Avatar.load(new File([await avatarFile()], 'boxes.vrm'));
  avatar.file.arrayBuffer = () => Promise.reject(new Error('it could not be read'));
  await assert.rejects(avatarGlb(replayOf(body, 5), avatar), /it could not be read/);
});
