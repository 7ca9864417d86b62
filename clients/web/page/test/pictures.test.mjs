import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Code, RefusedError } from 'styled-client';

import { JOINTS, drawFigure, filmOf, poseAt } from './dist/pictures.js';
import { Previews } from './dist/previews.js';

// A figure whose joints are at (joint, 1000, frame) mm.
const reply = (frames, fields = {}) => ({
  rateHz: 10, joints: JOINTS,
  positionsMm: Array.from({ length: 3 * frames * JOINTS }, (_, i) =>
    [Math.floor(i / 3) % JOINTS, 1000, 1000 * Math.floor(i / 3 / JOINTS)][i % 3]),
  ...fields,
});

test('what is no figure is none', () => {
  for (const fields of [{ joints: 20 }, { rateHz: 0 }, { rateHz: NaN }, { rateHz: 1e6 }, { positionsMm: [] },
                        { positionsMm: [1, 2, 3] }, { positionsMm: new Array(3 * JOINTS + 1).fill(0) },
                        { positionsMm: new Array(3 * JOINTS * 4000).fill(0) }]) {
    assert.equal(filmOf(reply(2, fields)), undefined, JSON.stringify(fields).slice(0, 60));
  }
});

test('metres; forward is to the right, and the body walks towards us', () => {
  const film = filmOf(reply(3));
  assert.deepEqual([film.frames, film.rate_hz], [3, 10]);
  const pose = poseAt(film, 0, new Float32Array(2 * JOINTS));
  assert.ok(Math.abs(pose[1] - 1) < 1e-6);
  assert.ok(poseAt(film, 0.1, new Float32Array(2 * JOINTS))[0] > pose[0] + 0.5, 'forward is to the right');
});

test('between two frames the figure is between them, and after the last comes the first', () => {
  const film = filmOf(reply(2));
  const x = (time_s) => poseAt(film, time_s, new Float32Array(2 * JOINTS))[0];
  assert.ok(Math.abs(x(0.05) - (x(0) + x(0.1)) / 2) < 1e-6);
  assert.ok(Math.abs(x(0.15) - (x(0) + x(0.1)) / 2) < 1e-6);
  for (const time_s of [0.2, 7.2, -0.2]) assert.ok(Math.abs(x(time_s) - x(0)) < 1e-4, String(time_s));
});

test('the drawing stays in its picture, with its feet on the ground', () => {
  const points = [];
  const pen = Object.fromEntries(['beginPath', 'stroke', 'fill', 'clearRect'].map((name) => [name, () => {}]));
  const add = (x, y) => points.push([x, y]);
  Object.assign(pen, { moveTo: add, lineTo: add, arc: (x, y, r) => points.push([x - r, y - r], [x + r, y + r]) });
  const pose = new Float32Array(2 * JOINTS);
  for (let joint = 0; joint < JOINTS; ++joint) pose.set([joint % 2 ? -0.7 : 0.7, joint === 16 ? 0 : 0.08 * joint], 2 * joint);
  drawFigure(pen, 84, 62, pose, { near: '#fff', far: '#888', ground: '#333' });
  for (const [x, y] of points) assert.ok(x >= 0 && x <= 84 && y >= 0 && y <= 62, `${x}, ${y}`);
  assert.ok(Math.max(...points.map(([, y]) => y)) > 56);
});

// Requests of previews that a test answers by hand.
function asking() {
  const asked = [];
  const previews = new Previews((style) => new Promise((resolve, reject) => asked.push({ style, resolve, reject })));
  previews.know(new Map(['a', 'b', 'c'].map((name) => [name, '1'])));
  const next = async (count) => {
    for (let i = 0; i < 500 && asked.length < count; ++i) await new Promise((resolve) => setTimeout(resolve, 5));
    assert.equal(asked.length, count);
    return asked.at(-1);
  };
  return { asked, previews, next };
}

test('one at a time, the most wanted first, none twice, none that is out of view', async () => {
  const { asked, previews, next } = asking();
  const came = [];
  previews.onFilm = (style) => came.push(style);
  previews.want(['b', 'a', 'c']);
  previews.want(['a', 'c']); // b is on its way
  assert.deepEqual(asked.map(({ style }) => style), ['b']);
  asked[0].resolve(reply(2));
  assert.equal((await next(2)).style, 'a');
  previews.want(['b', 'a']);
  asked[1].resolve(reply(2));
  await new Promise((resolve) => setTimeout(resolve, 100));
  assert.equal(asked.length, 2, 'c is out of view, the others are there');
  assert.deepEqual(came, ['b', 'a']);
  assert.ok(previews.film('a') && previews.film('b') && !previews.film('c'));
});

test('a style that became another one is asked for again', async () => {
  const { asked, previews, next } = asking();
  previews.want(['a']);
  previews.know(new Map([['a', '2']]));
  asked[0].resolve(reply(2)); // still of the old one
  await next(2);
  asked[1].resolve(reply(2));
  await new Promise((resolve) => setTimeout(resolve));
  assert.ok(previews.film('a'));
  previews.know(new Map([['a', '3']]));
  assert.equal(previews.film('a'), undefined);
});

test('a daemon without previews is asked once; another one again', async () => {
  const { asked, previews, next } = asking();
  let refusals = 0;
  previews.onRefused = () => ++refusals;
  previews.want(['a', 'b']);
  asked[0].reject(new RefusedError(Code.UNKNOWN_COMMAND, 'no such command'));
  await new Promise((resolve) => setTimeout(resolve, 100));
  assert.deepEqual([asked.length, refusals, previews.refused], [1, 1, true]);
  previews.forgive();
  await next(2);
});

test('a style without a picture does not keep the others from theirs', async () => {
  const { asked, previews, next } = asking();
  previews.want(['a', 'b']);
  asked[0].reject(new RefusedError(Code.UNKNOWN_STYLE, 'no style a'));
  assert.equal((await next(2)).style, 'b');
});
