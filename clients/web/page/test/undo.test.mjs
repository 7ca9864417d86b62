import assert from 'node:assert/strict';
import { test } from 'node:test';

import { UndoStack } from './dist/undo.js';

// A value whose changes can be taken back, with a clock that a test moves.
function make() {
  const clock = { now_ms: 0 };
  const stack = new UndoStack(() => clock.now_ms);
  const state = { value: 0 };
  const change = (value, gesture) => {
    const before = state.value;
    state.value = value;
    stack.push({ what: `to ${value}`, back: async () => void (state.value = before) }, gesture);
  };
  return { clock, stack, state, change };
}

test('nothing to undo', async () => {
  assert.equal(await make().stack.undo(), undefined);
});

test('a step that fails is kept, unless it never can be taken back', async () => {
  const { stack } = make();
  stack.push({ what: 'it', back: () => Promise.reject(new Error('pinned')) });
  await assert.rejects(stack.undo(), /pinned/);
  assert.equal(stack.size, 1);
  await assert.rejects(stack.undo(() => true), /pinned/);
  assert.equal(stack.size, 0);
});

test('while one is taken back, no other is', async () => {
  const { stack, change } = make();
  change(1);
  let go;
  stack.push({ what: 'slow', back: () => new Promise((resolve) => (go = resolve)) });
  const first = stack.undo();
  assert.equal(await stack.undo(), undefined);
  go();
  assert.equal((await first).what, 'slow');
  assert.equal(stack.size, 1);
});

test('at least twenty steps, newest first, and back to the beginning', async () => {
  const { stack, state, change } = make();
  for (let i = 1; i <= 25; ++i) change(i);
  for (let i = 25; i >= 1; --i) {
    assert.equal((await stack.undo()).what, `to ${i}`);
    assert.equal(state.value, i - 1);
  }
});

test('of very many steps the oldest are forgotten', async () => {
  const { stack, state, change } = make();
  for (let i = 1; i <= 500; ++i) change(i);
  assert.equal(stack.size, 50);
  while (stack.size > 0) await stack.undo();
  assert.equal(state.value, 450);
});

test('a gesture is one step, back to where it began', async () => {
  const { clock, stack, state, change } = make();
  change(5);
  for (let i = 6; i <= 9; ++i) {
    clock.now_ms += 1000;
    change(i, 'strength');
  }
  assert.equal(stack.size, 2);
  assert.equal(stack.last.what, 'to 9');
  await stack.undo();
  assert.equal(state.value, 5);
});

test('gestures of two knobs, and of one after a pause, are two', () => {
  const { clock, stack, change } = make();
  change(1, 'strength');
  change(2, 'amount');
  change(3, 'strength');
  assert.equal(stack.size, 3);
  clock.now_ms = 2000;
  change(4, 'strength');
  assert.equal(stack.size, 4);
});

test('what is to be said of a step that was taken back is told; steps that became part of another are', async () => {
  const { stack } = make();
  const left = { what: 'it', back: async () => 'rig.a: changed by someone else' };
  assert.deepEqual([stack.push(left, 'strength'), stack.push(left, 'strength'), stack.push(left)], [false, true, false]);
  assert.deepEqual(await stack.undo(), { what: 'it', remark: 'rig.a: changed by someone else' });
});
