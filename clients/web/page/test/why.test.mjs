// How often each of the daemon's sentences holds.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Fate } from 'styled-client';

import { causes } from './dist/why.js';

const frame = (cause, fate = Fate.STYLED, isBody = false) => ({ cause, fate, isBody });

test('the most frequent cause comes first, and what is well is counted', () => {
  const found = causes([frame(''), frame('late'), frame('held'), frame('held'), frame(''), frame('')]);
  assert.deepEqual(found, { well: 3, causes: [{ text: 'held', count: 2 }, { text: 'late', count: 1 }] });
});

test('bodies are no frames, and a refused frame is not well', () => {
  assert.deepEqual(causes([frame('', Fate.REFUSED, true), frame('a duplicate', Fate.REFUSED)]),
    { well: 0, causes: [{ text: 'a duplicate', count: 1 }] });
});
