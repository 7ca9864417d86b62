import assert from 'node:assert/strict';
import { test } from 'node:test';

import { kindOf, nameFault, proposedName, replacedBy } from './dist/names.js';

const taken = { made: new Set(['pirate']), fixed: new Set(['elderly', 'old', 'calm']) };

test('what cannot be a name, each for its reason', () => {
  for (const [name, fault] of [
    ['', /needs a name/], ['a'.repeat(33), /at most 32 letters; this one has 33/], ['käpt', /only letters/], ['two words', /only letters/],
    ['a/b', /only letters/], ['elderly', /elderly is already a name of the weights/], ['Elderly', /of the weights/], ['OLD', /of the weights/], ['calm', /preset/], ['-x', /begin with -/], ['Panic', /another meaning/],
  ]) assert.match(nameFault(name, taken), fault, name);
});

test('a free name, and one that replaces', () => {
  assert.equal(nameFault('captain_2', taken), '');
  assert.equal(nameFault('pirate', taken), '');
  assert.equal(replacedBy('pirate', taken), 'pirate');
  assert.equal(replacedBy('captain', taken), '');
});

test('a name is proposed after the file', () => {
  for (const [file, name] of [
    ['captain.bvh', 'captain'], ['Old Man (2).final.glb', 'Old-Man-2-final'], ['C:\\clips\\walk.vrma', 'walk'], ['clips/walk.vrma', 'walk'],
    ['Käpt’n.bvh', 'Kapt-n'], ['海賊.bvh', 'style'], ['', 'style'], ['.bvh', 'style'], [`${'x'.repeat(60)}.bvh`, 'x'.repeat(32)],
    ['pirate.bvh', 'pirate-2'], ['elderly.bvh', 'elderly-2'], ['OLD.bvh', 'OLD-2'], ['-x.bvh', 'x'], ['bypass.bvh', 'bypass-2'],
  ]) {
    assert.equal(proposedName(file, taken), name, file);
    assert.equal(nameFault(proposedName(file, taken), taken), '', file);
  }
  const long = { made: new Set(['x'.repeat(32)]), fixed: new Set() };
  assert.equal(proposedName(`${'x'.repeat(40)}.bvh`, long), `${'x'.repeat(30)}-2`);
});

test('what a file is for', () => {
  assert.deepEqual(['a.vrm', 'a.BVH', 'a.b.glb', 'a.vrma', 'a.json', 'a.png', 'bvh', 'a.'].map(kindOf),
    ['avatar', 'example', 'example', 'example', 'style', 'other', 'other', 'other']);
});
