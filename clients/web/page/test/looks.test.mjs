import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { BodyPart, LookSchema, Root } from 'styled-client';

import { changeTo, sameLook } from './dist/looks.js';

const look = (fields = {}) => create(LookSchema, {
  mix: [{ style: 'elderly', weight: 0.5 }], strength: 0.8, transitionMs: 100, absolute: false, parts: [BodyPart.ALL],
  inputStyle: '', preset: '', root: Root.FOLLOW, ...fields,
});

test('looks are the same whatever their fades are', () => {
  assert.ok(sameLook(look(), look({ transitionMs: 5 })));
  for (const fields of [{ mix: [] }, { strength: 1 }, { absolute: true }, { parts: [BodyPart.HEAD] }, { root: Root.STRIDE }, { inputStyle: 'sad' },
                        { vary: 7 }, { varyEach: true }, { varyAmount: 0.5 }, { driftS: 5 }, { mirror: true }]) {
    assert.ok(!sameLook(look(), look(fields)), JSON.stringify(fields));
  }
});

test('back to a mix, with everything that the daemon reported and nothing else', () => {
  assert.deepEqual(changeTo(look(), [], 300), {
    mix: [{ style: 'elderly', weight: 0.5 }], strength: 0.8, absolute: false, parts: [BodyPart.ALL], inputStyle: '', root: Root.FOLLOW, transitionMs: 300,
  });
  assert.equal(changeTo(look({ vary: 7, driftS: 0 }), [], 0).vary, 7);
  assert.ok(!('vary' in changeTo(look(), [], 0)));
});

test('back to bypass, and to a preset if there still is one', () => {
  const bypass = changeTo(look({ mix: [] }), [], 0);
  assert.deepEqual([bypass.clear, bypass.mix], [true, undefined]);
  const preset = changeTo(look({ preset: 'calm' }), ['calm'], 0);
  assert.deepEqual([preset.preset, preset.mix, preset.clear], ['calm', undefined, undefined]);
  assert.equal(changeTo(look({ preset: 'calm' }), [], 0).preset, undefined);
  assert.ok(changeTo(look({ preset: 'calm' }), [], 0).mix);
});
