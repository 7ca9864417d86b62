// The expressions that a rig sends, as an avatar shows them.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { expressionsOf, presetOf } from 'styled-client';

const VRM1 = ['happy', 'angry', 'sad', 'relaxed', 'surprised', 'aa', 'ih', 'ou', 'ee', 'oh', 'blink', 'blinkLeft',
  'blinkRight', 'lookUp', 'lookDown', 'lookLeft', 'lookRight', 'neutral'];
const PERFECT = [...VRM1, 'eyeBlinkLeft', 'eyeBlinkRight', 'JawOpen', 'mouthPucker', 'eyeLookUpLeft'];
const shown = (sent, own = VRM1, eyes = false) =>
  Object.fromEntries(expressionsOf(Object.entries(sent).map(([name, value]) => ({ name, value })), own, eyes));

test('values that are none, too large or below 0, and names that nobody knows', () => {
  assert.deepEqual(shown({ Joy: NaN, angry: -1, sad: 7, relaxed: Infinity, tailWag: 1, '': 1 }), { sad: 1, relaxed: 1 });
  assert.deepEqual(shown({ Joy: 1, eyeBlinkLeft: 1, jawOpen: 1 }, []), {});
  assert.deepEqual(shown({}), {});
});

test("VRM 0's names are VRM 1.0's presets, whatever their case", () => {
  assert.deepEqual(shown({ Joy: 0.5, A: 0.25, BLINK_L: 0.75, LookUp: 1, SURPRISED: 0.5 }),
    { happy: 0.5, aa: 0.25, lookUp: 1, surprised: 0.5, blinkLeft: 0.75 });
});

test("an avatar's own expression of that name comes first", () => {
  assert.deepEqual(shown({ joy: 0.5, TailWag: 1 }, [...VRM1, 'Joy', 'tailwag']), { Joy: 0.5, tailwag: 1 });
});

test("ARKit's names move an avatar that has them, and presets of one that has not", () => {
  const sent = { eyeBlinkLeft: 0.5, jawOpen: 0.25, eyeLookUpLeft: 1, eyeLookUpRight: 0.5 };
  assert.deepEqual(shown(sent, PERFECT), { eyeBlinkLeft: 0.5, JawOpen: 0.25, eyeLookUpLeft: 1 });
  assert.deepEqual(shown(sent), { blinkLeft: 0.5, aa: 0.25, lookUp: 0.75 });
  assert.deepEqual(shown({ eyeLookOutLeft: 1, eyeLookInRight: 1 }), { lookLeft: 1 });
  // At rest trackers say a little of everything: no mood. Of two moods the stronger one.
  assert.deepEqual(shown({ mouthSmileLeft: 0.15, mouthSmileRight: 0.15, browDownLeft: 0.1 }), {});
  assert.deepEqual(shown({ mouthSmileLeft: 1, mouthSmileRight: 1, browDownLeft: 0.6, browDownRight: 0.6 }), { happy: 1 });
});

test('never a preset and its parts at once', () => {
  assert.deepEqual(shown({ Blink: 0.8, Blink_L: 0.5 }), { blink: 0.8 });
  assert.deepEqual(shown({ Blink: 0.3, Blink_L: 1 }), { blinkLeft: 1, blinkRight: 0.3 });
  assert.deepEqual(shown({ eyeBlinkLeft: 1, eyeBlinkRight: 1 }), { blink: 1 });
  assert.deepEqual(shown({ blink: 1 }, ['blinkLeft', 'blinkRight']), { blinkLeft: 1, blinkRight: 1 });
  assert.deepEqual(shown({ Blink_L: 1, Blink_R: 0.2 }, ['Blink']), { Blink: 0.2 }); // it cannot wink
  // Both kinds are sent: those of the face's parts, if they move it.
  assert.deepEqual(shown({ A: 0.5, jawOpen: 0.4, Blink: 1, eyeBlinkLeft: 1, eyeBlinkRight: 1 }, PERFECT),
    { JawOpen: 0.4, eyeBlinkLeft: 1, eyeBlinkRight: 1 });
  assert.deepEqual(shown({ A: 0.5, jawOpen: 0 }, PERFECT), { aa: 0.5 });
  // A mouth opens once.
  const mouth = shown({ jawOpen: 1, mouthFunnel: 1 });
  assert.deepEqual(mouth, { aa: 0.5, oh: 0.5 });
});

test('eyes that bones turn are not turned by expressions, too', () => {
  assert.deepEqual(shown({ lookLeft: 1, eyeLookUpLeft: 1, eyeLookUpRight: 1, joy: 1 }, VRM1, true), { happy: 1 });
});

test('the preset that a name means', () => {
  assert.deepEqual(['Joy', 'BLINK_L', 'blinkRight', 'A', 'neutral', 'eyeBlinkLeft', ''].map(presetOf),
    ['happy', 'blinkLeft', 'blinkRight', 'aa', 'neutral', undefined, undefined]);
});
