// The BVH writer, compared with three.js' reader and with the client's forward kinematics.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Euler, Quaternion } from 'three';
import { worldTransforms } from 'styled-client';

import { bvhText } from './dist/bvh.js';
import { makeBody, randomOf, readBvh, turn } from './support.mjs';

const TENTH_OF_MM = 1e-4;
const textOf = (body, rate_hz, poses) => [...bvhText(body, rate_hz, poses.length, poses)].join('');
const anglesOf = (text) =>
  text.slice(text.indexOf('Frame Time')).trim().split('\n').slice(1).map((row) => row.split(' ').map(Number));

function assertSame(body, pose, found, tolerance = TENTH_OF_MM) {
  const { positions } = worldTransforms(body, { rootPosition: pose.slice(0, 3), rotations: pose.slice(3) });
  body.names.forEach((name, joint) => {
    const apart = Math.hypot(...found.get(name).map((x, i) => x - positions[3 * joint + i]));
    assert.ok(apart < tolerance, `${name} is ${1000 * apart} mm off`);
  });
}

test('three.js poses every joint where our forward kinematics has it', () => {
  const body = makeBody();
  const random = randomOf(3);
  const poses = Array.from({ length: 40 }, () => [
    ...Array.from({ length: 3 }, () => 20 * random() - 10),
    ...body.names.flatMap(() => Array.from({ length: 4 }, () => random() - 0.5)),
  ]);
  const read = readBvh(textOf(body, 120, poses));
  assert.equal(read.frames, poses.length);
  poses.forEach((pose, frame) => assertSame(body, pose, read.positions(frame)));
});

test('half turns, quarter turns and what is just beside them', () => {
  const body = makeBody();
  const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1], [1, -1, 1]];
  const angles = [0, 90, -90, 180, -180, 179.9999, 270, 89.99999, 90.00001].map((degrees) => degrees * Math.PI / 180);
  const poses = axes.flatMap((axis) => angles.map((angle) => [0, 1, 0, ...body.names.flatMap(() => turn(axis, angle))]));
  const read = readBvh(textOf(body, 60, poses));
  poses.forEach((pose, frame) => assertSame(body, pose, read.positions(frame)));
});

test('angles go on over half a turn, and over the quarter turn where two of them are one', () => {
  const body = makeBody();
  for (const axis of [[0, 0, 1], [1, 0, 0], [0, 1, 0], [0.3, 1, 0.1]]) {
    const poses = Array.from({ length: 500 }, (_, i) => [0, 1, 0, ...body.names.flatMap(() => turn(axis, 0.05 * i))]);
    const rows = anglesOf(textOf(body, 120, poses));
    for (let i = 1; i < rows.length; ++i) {
      rows[i].forEach((angle, k) =>
        assert.ok(Math.abs(angle - rows[i - 1][k]) < 30, `${rows[i - 1][k]} to ${angle} in row ${i} about ${axis}`));
    }
  }
});

test('where two angles are one, rounding of the rotation does not throw them about', () => {
  const body = makeBody();
  const q = new Quaternion();
  // Up to the quarter turn, then on about the last axis.
  const poses = Array.from({ length: 100 }, (_, i) => {
    const degrees = [Math.min(90, 80 + i), 20 + i, 30]; // of x, y, z
    q.setFromEuler(new Euler(...degrees.map((x) => x * Math.PI / 180), 'ZXY'));
    return Float32Array.from([0, 1, 0, ...body.names.flatMap(() => q.toArray())]);
  });
  anglesOf(textOf(body, 120, poses)).forEach((row, i) =>
    [30, Math.min(90, 80 + i), 20 + i].forEach((angle, k) =>
      assert.ok(Math.abs(row[3 + k] - angle) < 0.1, `${row.slice(3, 6)} in row ${i}`)));
});

test('the quaternion and its negative are one pose', () => {
  const body = makeBody();
  const random = randomOf(11);
  const pose = [0, 1, 0, ...body.names.flatMap(() => Array.from({ length: 4 }, () => random() - 0.5))];
  const rows = anglesOf(textOf(body, 120, [pose, [...pose.slice(0, 3), ...pose.slice(3).map((x) => -x)]]));
  assert.deepEqual(rows[0], rows[1]);
});

test('the header: order of channels, the step, the root without an offset, ends of chains', () => {
  const body = makeBody();
  const text = textOf(body, 120, [[1, 2, 3, ...body.names.flatMap(() => [0, 0, 0, 1])]]);
  assert.match(text, /^HIERARCHY\nROOT joint0\n\{\n\tOFFSET 0\.000000 0\.000000 0\.000000\n\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n\tJOINT joint1\n/);
  assert.match(text, /\nMOTION\nFrames: 1\nFrame Time: 0\.008333333\n1\.000000 2\.000000 3\.000000 0\.000000 /);
  assert.equal(text.match(/CHANNELS 3 Zrotation Xrotation Yrotation/g).length, body.names.length - 1);
  assert.equal(text.match(/End Site/g).length, 4);
});

test('names become one word each, and stay different', () => {
  const body = makeBody({ names: ['left hip', 'left_hip', ' ', 'a{b', ...[...'cdefghi']] });
  const read = readBvh(textOf(body, 30, [[0, 0, 0, ...body.names.flatMap(() => [0, 0, 0, 1])]]));
  assert.equal(new Set(read.names).size, body.names.length);
  assert.deepEqual(read.names.slice(0, 2), ['left_hip', 'left_hip_']);
  assert.ok(read.names.includes('a_b') && read.names.includes('joint_2'));
});

test('centimetres stay centimetres', () => {
  const body = makeBody({ metresPerUnit: 0.01 });
  body.offsets = body.offsets.map((x) => 100 * x);
  const random = randomOf(5);
  const pose = [120.5, 95.25, -300.75, ...body.names.flatMap(() => Array.from({ length: 4 }, () => random() - 0.5))];
  assertSame(body, pose, readBvh(textOf(body, 120, [pose])).positions(0), 100 * TENTH_OF_MM);
});
