// The resolution with software rendering.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Sharpness } from './dist/sharpness.js';

const during = (sharpness, seconds, fps) => {
  let ratio;
  for (let i = 0; i < seconds; ++i) ratio = sharpness.next(fps);
  return ratio;
};

test('slow pictures lose pixels at once, down to the least', () => {
  const sharpness = new Sharpness(1);
  assert.ok(Math.abs(sharpness.next(20) - 0.9) < 1e-9);
  assert.equal(during(sharpness, 20, 5), 0.6);
});

test('quick pictures get them back, one step in five seconds, up to where it began', () => {
  const sharpness = new Sharpness(1);
  const low = during(sharpness, 3, 20);
  assert.equal(during(sharpness, 4, 60), low);
  assert.ok(sharpness.next(60) > low);
  assert.equal(during(sharpness, 60, 60), 1);
});

test('neither quick nor slow, or quick only now and then, changes nothing', () => {
  const sharpness = new Sharpness(1);
  const low = during(sharpness, 3, 20);
  assert.equal(during(sharpness, 60, 33), low);
  for (let i = 0; i < 20; ++i) {
    during(sharpness, 4, 60);
    assert.equal(sharpness.next(33), low);
  }
});

test('a step that was too much is tried ever more rarely', () => {
  const sharpness = new Sharpness(1);
  let ratio = sharpness.next(20), changes = 0;
  // A machine that is fast below full resolution, and slow at it.
  for (let second = 0; second < 600; ++second) {
    const next = sharpness.next(ratio > 0.95 ? 20 : 60);
    if (next !== ratio) ++changes;
    ratio = next;
  }
  assert.ok(changes >= 4 && changes < 30, `${changes} changes in ten minutes`);
});
