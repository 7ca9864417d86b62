import assert from 'node:assert/strict';
import { test } from 'node:test';

import { cueBeside, cuesOf } from './dist/cues.js';

const cue = (name, performer = '*', at = '') => ({ name, performer, at });

test('cues of one name are one, in the order of the configuration', () => {
  const cues = cuesOf([cue('in'), cue('turn', 'rig.a', '01:02:03:04'), cue('in', 'rig.b'), cue('out')]);
  assert.deepEqual(cues, [
    { name: 'in', words: 'everyone, rig.b' }, { name: 'turn', words: 'rig.a at 01:02:03:04' }, { name: 'out', words: 'everyone' }]);
  assert.deepEqual(cuesOf([]), []);
});

test('GO begins with the first and ends with the last; Back needs one before', () => {
  const cues = cuesOf([cue('a'), cue('b'), cue('c')]);
  const beside = (current, step) => cueBeside(cues, current, step);
  assert.deepEqual(['', 'a', 'b', 'c'].map((current) => beside(current, 1)), ['a', 'b', 'c', undefined]);
  assert.deepEqual(['', 'a', 'b', 'c'].map((current) => beside(current, -1)), [undefined, undefined, 'a', 'b']);
  assert.equal(cueBeside([], '', 1), undefined);
});
