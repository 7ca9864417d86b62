import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Live, choicesOf, designOf, groupsOf, handName, sameSliders, stepOf, wordsOf } from './dist/design.js';

const slider = (name, group, usual = 0) => ({ name, group, usual, title: name, unit: '', least: 0, most: 1, what: '' });
const style = (name, fields = {}) => ({ name, neutral: false, made: false, designable: false, sliders: {}, ...fields });
const list = {
  styles: [style('neutral', { neutral: true }), style('old', { designable: true }), style('graph'),
           style('by-hand-rig-a', { made: true, designable: true, sliders: { stoop: 12 } }), style('pirate', { made: true })],
  sliders: [slider('stoop', 'Posture'), slider('energy', 'Character', 1), slider('chin', 'Posture')],
  designs: [{ name: 'sneaky', sliders: { stoop: 28, energy: 0.6 } }],
};

test("the name is the daemon's", () => {
  assert.equal(handName('rig.anna'), 'by-hand-rig-anna');
  assert.equal(handName(`stage.${'x'.repeat(32)}`).length, 32);
});

test('a style begins with the neutral performer, a design, a made style, or one of a network with sliders', () => {
  assert.deepEqual(choicesOf(list).map(({ group, choices }) => [group, ...choices.map(({ value }) => value)]), [
    ['', 'style neutral'], ['Designs', 'design sneaky'], ['Made styles', 'style by-hand-rig-a', 'style pirate'], ['Styles', 'style old']]);
  assert.deepEqual(choicesOf({ styles: [], sliders: [], designs: [] }), []);
});

test('a design has a value of each slider: its own, that of the style, or the usual one', () => {
  assert.deepEqual(designOf(list, 'style neutral'), { from: 'neutral', sliders: { stoop: 0, energy: 1, chin: 0 } });
  assert.deepEqual(designOf(list, 'design sneaky'), { from: 'neutral', sliders: { stoop: 28, energy: 0.6, chin: 0 } });
  assert.deepEqual(designOf(list, 'style by-hand-rig-a'), { from: 'by-hand-rig-a', sliders: { stoop: 12, energy: 1, chin: 0 } });
  for (const gone of ['style gone', 'design gone', '']) assert.equal(designOf(list, gone), undefined, gone);
});

test('values are equal in single precision, as the daemon has them', () => {
  const a = { from: 'x', sliders: { energy: 0.6, stoop: 3 } };
  assert.ok(sameSliders(a, { from: 'y', sliders: { energy: Math.fround(0.6), stoop: 3 } }));
  assert.ok(!sameSliders(a, { from: 'x', sliders: { energy: 0.61, stoop: 3 } }));
  assert.ok(!sameSliders(a, { from: 'x', sliders: { energy: 0.6 } }));
  assert.ok(!sameSliders(a, { from: 'x', sliders: { energy: 0.6, chin: 3 } }));
});

test('steps and words fit the range and the unit', () => {
  assert.deepEqual([[-30, 60], [0, 8], [0, 15], [0, 2], [0, 0.5]].map(([least, most]) => stepOf({ least, most })), [1, 0.1, 0.1, 0.01, 0.01]);
  assert.deepEqual(wordsOf('degrees', -28), { read: '-28°', heard: '-28 degrees' });
  assert.deepEqual(wordsOf('s', 0.1600001), { read: '0.16 s', heard: '0.16 seconds' });
  assert.deepEqual(wordsOf('', 0.6), { read: '× 0.6', heard: 'times 0.6' });
  assert.deepEqual(wordsOf('m', 1), { read: '1 m', heard: '1 m' });
});

test("groups keep the daemon's order", () => {
  assert.deepEqual([...groupsOf(list.sliders)].map(([group, sliders]) => [group, ...sliders.map(({ name }) => name)]),
    [['Posture', 'stoop', 'chin'], ['Character', 'energy']]);
});

// Values that are sent, and answered by hand.
function sending(rest = () => {}) {
  const sent = [];
  const live = new Live((key, value) => new Promise((done, fail) => sent.push({ key, value, done, fail })), rest, 30);
  const answer = async (at) => {
    sent[at].done();
    await new Promise((resolve) => setTimeout(resolve));
  };
  return { sent, live, answer };
}

test('never a second before the first is answered; then the newest, of each performer', async () => {
  const { sent, live, answer } = sending();
  for (const value of [1, 2, 3]) live.put('a', value);
  live.put('b', 7);
  live.put('a', 4);
  await new Promise((resolve) => setTimeout(resolve, 20));
  assert.deepEqual(sent.map(({ value }) => value), [1]);
  await answer(0);
  assert.deepEqual(sent.map(({ key, value }) => [key, value]), [['a', 1], ['a', 4]]);
  await answer(1);
  assert.deepEqual(sent.slice(2).map(({ key, value }) => [key, value]), [['b', 7]]);
  await answer(2);
  live.put('a', 5);
  assert.equal(sent.length, 4);
});

test('it rests once nothing comes any more, not between two values', async () => {
  let rests = 0;
  const { live, answer } = sending(() => ++rests);
  live.put('a', 1);
  await answer(0);
  await new Promise((resolve) => setTimeout(resolve, 10));
  live.put('a', 2);
  await new Promise((resolve) => setTimeout(resolve, 60));
  assert.equal(rests, 0, 'the second is on its way');
  await answer(1);
  await new Promise((resolve) => setTimeout(resolve, 60));
  assert.equal(rests, 1);
});

test('a waiting value can be dropped, and the last reply awaited', async () => {
  const { sent, live, answer } = sending();
  await live.settled(); // nothing is sent
  live.put('a', 1);
  live.put('a', 2);
  live.drop('a');
  let settled = false;
  const waited = live.settled().then(() => (settled = true));
  await new Promise((resolve) => setTimeout(resolve, 10));
  assert.equal(settled, false);
  await answer(0);
  await waited;
  assert.equal(sent.length, 1);
  live.put('a', 3); // later values are sent
  assert.equal(sent.length, 2);
});
