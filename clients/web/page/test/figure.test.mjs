// The figure of a body that has more joints than the humanoid.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Output } from 'styled-client';

import { COARSE, Figure } from './dist/figure.js';
import { skeletonOf } from './dist/skeleton.js';
import { HUMANOID } from '../../../js/test-support/humanoid.mjs';
import { makeBody } from './support.mjs';

/** Metres from the head joint up to the top of the figure in the T-pose. */
function above(more) {
  const joints = [...HUMANOID, ...more];
  const skeleton = skeletonOf(makeBody({
    names: joints.map(([name]) => name), parents: joints.map(([, parent]) => parent), output: Output.CANONICAL,
    offsets: joints.flatMap(([, , ...offset]) => offset),
  }));
  const figure = new Figure(skeleton, { color: 0xffffff }, COARSE);
  const { geometry } = figure.group.children[0];
  geometry.computeBoundingBox();
  return geometry.boundingBox.max.y - skeleton.rest[4].position.y;
}

test('eyes, a jaw and hair do not take the head away', () => {
  const plain = above([]);
  assert.ok(plain > 0.15, `${plain}: a head is there`);
  const eyed = above([['leftEye', 4, 0.03, 0.06, 0.08], ['rightEye', 4, -0.03, 0.06, 0.08], ['jaw', 4, 0, 0.01, 0.02]]);
  assert.ok(Math.abs(eyed - plain) < 0.03, `${eyed}, expected ${plain}`);
});
