import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { BodySchema, FrameSchema, checkBody, checkFrame, parseTopic, worldTransforms } from 'styled-client';

const makeBody = (fields = {}) =>
  create(BodySchema, {
    names: ['hips', 'spine', 'hand'], parents: [-1, 0, 1], offsets: [9, 9, 9, 0, 0.5, 0, 1, 0, 0], hash: 5n, output: 2,
    ...fields,
  });
const half = Math.SQRT1_2;
const close = (found, wanted) =>
  wanted.forEach((value, i) => assert.ok(Math.abs(found[i] - value) < 1e-6, `${[...found]} is not ${wanted}`));

test('a root that is turned and moved carries its children; its own offset is not added', () => {
  const frame = create(FrameSchema, {
    bodyHash: 5n, output: 2, rootPosition: [1, 2, 3],
    // a quarter turn about Z, then one about Y; the last quaternion has length 2
    rotations: [0, 0, half, half, 0, half, 0, half, 0, 0, 0, 2],
  });
  const body = makeBody();
  assert.equal(checkFrame(body, frame), '');
  const { positions, rotations } = worldTransforms(body, frame);
  close(positions.subarray(0, 3), [1, 2, 3]);
  close(positions.subarray(3, 6), [0.5, 2, 3]); // +Y rotated to -X
  close(positions.subarray(6, 9), [0.5, 2, 2]); // +X about Y to -Z, which the rotation about Z leaves unchanged
  close(rotations.subarray(8, 12), rotations.subarray(4, 8));
  close(rotations.subarray(4, 8), [-0.5, 0.5, 0.5, 0.5]);
});

test('agrees with a chain of matrices over many random poses', () => {
  let seed = 1;
  const random = () => ((seed = (seed * 48271) % 2147483647) / 2147483647) * 2 - 1;
  for (let round = 0; round < 200; ++round) {
    const joints = 8;
    const body = makeBody({
      names: [...Array(joints).keys()].map(String),
      parents: [...Array(joints).keys()].map((j) => (j === 0 ? -1 : Math.floor(((random() + 1) / 2) * j))),
      offsets: Array.from({ length: 3 * joints }, random),
    });
    const rotations = Array.from({ length: 4 * joints }, random);
    const frame = create(FrameSchema, { rootPosition: [random(), random(), random()], rotations, bodyHash: 5n, output: 2 });
    assert.equal(checkBody(body), '');
    const found = worldTransforms(body, frame);
    const matrices = [];
    for (let j = 0; j < joints; ++j) {
      const q = frame.rotations.slice(4 * j, 4 * j + 4);
      const n = Math.hypot(...q);
      const [x, y, z, w] = q.map((v) => v / n);
      const local = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
      ];
      const parent = matrices[body.parents[j]];
      const times = (m, v) => m.map((row) => row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
      const offset = [...body.offsets.slice(3 * j, 3 * j + 3)];
      matrices.push(parent
        ? { r: parent.r.map((row) => [0, 1, 2].map((c) => row[0] * local[0][c] + row[1] * local[1][c] + row[2] * local[2][c])),
            p: times(parent.r, offset).map((v, i) => v + parent.p[i]) }
        : { r: local, p: [...frame.rootPosition] });
      matrices[j].p.forEach((v, i) => assert.ok(Math.abs(v - found.positions[3 * j + i]) < 1e-4));
    }
  }
});

test('bodies and frames that do not fit are refused, each for its reason', () => {
  assert.match(checkBody(makeBody({ names: [] })), /0 joints/);
  assert.match(checkBody(makeBody({ parents: [-1, 0] })), /do not belong/);
  assert.match(checkBody(makeBody({ parents: [0, 0, 1] })), /parent/);
  assert.match(checkBody(makeBody({ parents: [-1, 2, 1] })), /parent/);
  assert.match(checkBody(makeBody({ rest: [0, 0, 0, 1] })), /rest/);
  assert.match(checkBody(makeBody({ offsets: [0, 0, 0, 0, Infinity, 0, 0, 0, 0] })), /finite/);
  const good = { bodyHash: 5n, output: 2, rootPosition: [0, 0, 0], rotations: [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1] };
  const wrong = (fields) => checkFrame(makeBody(), create(FrameSchema, { ...good, ...fields }));
  assert.equal(wrong({}), '');
  assert.match(wrong({ bodyHash: 6n }), /another body/);
  assert.match(wrong({ output: 1 }), /another body/);
  assert.match(wrong({ rotations: [0, 0, 0, 1] }), /3 joints/);
  assert.match(wrong({ rootPosition: [0, 0] }), /3 joints/);
  assert.match(wrong({ rootPosition: [0, Infinity, 0] }), /finite/);
  assert.match(wrong({ rotations: [0, 0, 0, 1, NaN, 0, 0, 1, 0, 0, 0, 1] }), /rotation 1/);
  const sword = { name: 'sword', position: [1, 2, 3], rotation: [0, 0, 0, 1] };
  assert.equal(wrong({ props: [sword, { ...sword, name: 'cup' }] }), '');
  assert.match(wrong({ props: [sword, { ...sword, position: [1, 2] }] }), /prop "sword" has no pose/);
  assert.match(wrong({ props: [{ ...sword, position: [1, NaN, 2] }] }), /prop/);
  assert.match(wrong({ props: [{ ...sword, rotation: [0, 0, 0, 0] }] }), /prop/);
});

test('topics', () => {
  assert.deepEqual(parseTopic('styled/rig.a/rig/'), { kind: 'frame', performer: 'rig.a', stream: 'rig' });
  assert.deepEqual(parseTopic('source/rig.a/'), { kind: 'frame', performer: 'rig.a', stream: 'source' });
  assert.deepEqual(parseTopic('body/rig.a/'), { kind: 'body', performer: 'rig.a' });
  assert.deepEqual(parseTopic('stats/'), { kind: 'stats' });
  for (const odd of ['', 'styled/rig.a/', 'source/rig.a/rig/', 'body/', 'styled/rig.a/face/', 'x/y/']) {
    assert.equal(parseTopic(odd), undefined);
  }
});
