// A take that is played again: what a video of it shows at each moment.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Output } from 'styled-client';

import { Replay } from './dist/replay.js';
import { Track } from './dist/take.js';
import { makeBody, makeFrame, turn } from './support.mjs';

const body = makeBody();
const humanoid = makeBody({ output: Output.CANONICAL, hash: 8n });

function trackOf(count, { from = 0, rate_hz = 120, gone = [], fields = () => ({}), of = body } = {}) {
  const track = new Track(of.names.length);
  for (let i = from; i < count; ++i) {
    if (gone.includes(i)) continue;
    track.add(makeFrame(of, i, {
      sourceTimeNs: BigInt(Math.round((i * 1e9) / rate_hz)), receiveTimeNs: BigInt(Math.round((i * 1e9) / rate_hz)),
      rootPosition: [i / rate_hz, 1, 0], ...fields(i),
    }));
  }
  return track;
}
const takeOf = (fields) => ({ performer: 'rig.a', body, begun: new Date(), ...fields });

test('too short a take, and one whose streams share no moment', () => {
  assert.equal(Replay.of(takeOf({ source: trackOf(1), styled: trackOf(1) })), undefined);
  assert.equal(Replay.of(takeOf({ source: trackOf(10), styled: trackOf(40, { from: 20 }) })), undefined);
});

test('each moment has its pose, also where frames are lost, and 60 pictures of 120 frames have every second one', () => {
  const replay = Replay.of(takeOf({ source: trackOf(240, { gone: [50, 51] }), styled: trackOf(240) }));
  assert.equal(replay.duration_s, 2);
  for (let i = 0; i < 120; ++i) {
    for (const stream of ['source', 'rig']) {
      const { frame, body: own } = replay.at(stream, i / 60);
      assert.equal(own, body);
      assert.ok(Math.abs(frame.rootPosition[0] - i / 60) < 1e-6, `${stream}, picture ${i}: ${frame.rootPosition}`);
    }
  }
  assert.equal(replay.at('canonical', 0), undefined);
  assert.ok(Math.abs(replay.at('rig', 9).frame.rootPosition[0] - 239 / 120) < 1e-6, 'behind the end the last pose');
});

test('the humanoid that an avatar needs, its face and contacts', () => {
  const track = trackOf(120, { of: humanoid, fields: (i) => ({ contacts: i % 2, expressions: i < 60 ? [{ name: 'Joy', value: 1 }] : [] }) });
  const replay = Replay.of(takeOf({ source: trackOf(120), styled: trackOf(120), canonical: { body: humanoid, track } }));
  const at = (time_s) => replay.at('canonical', time_s);
  assert.deepEqual(at(0.25).frame.expressions.map(({ name, value }) => [name, value]), [['Joy', 1]]);
  assert.deepEqual(at(0.75).frame.expressions, []);
  assert.equal(at(0.75).frame.bodyHash, 8n);
});

test('without a shared moment of the humanoid the body alone is played', () => {
  const replay = Replay.of(takeOf({ source: trackOf(120), styled: trackOf(120), canonical: { body: humanoid, track: trackOf(300, { from: 200, of: humanoid }) } }));
  assert.equal(replay.duration_s, 1);
  assert.equal(replay.at('canonical', 0), undefined);
});

test('props are where they were, between two frames on the way, and go with the frame that has them not', () => {
  const tip = (i) => turn([0, 0, 1], i / 100);
  const sword = (i) => ({ name: 'sword', position: [i / 50, 1, 0], rotation: tip(i) });
  const props = (i) => (i < 20 ? [] : i < 60 ? [sword(i), { name: 'chair', position: [0, 0, 1], rotation: [0, 0, 0, 0] }] : [sword(i)]);
  const tracks = [0, 1].map(() => trackOf(100, { rate_hz: 50, gone: [41], fields: (i) => ({ props: props(i) }) }));
  const replay = Replay.of(takeOf({ source: tracks[0], styled: tracks[1] }));
  for (const [i, names] of [[0, ''], [19, ''], [20, 'sword,chair'], [30.6, 'sword,chair'], [41, 'sword,chair'], [59.5, 'sword,chair'], [60, 'sword'], [99, 'sword']]) {
    for (const stream of ['source', 'rig']) {
      const found = replay.at(stream, i / 50).frame.props;
      assert.equal(found.map(({ name }) => name).join(), names, `${stream} at frame ${i}`);
      if (found.length === 0) continue;
      const [{ position, rotation }] = found;
      assert.ok(Math.abs(position[0] - i / 50) < 1e-5 && position[1] === 1, `${stream} at frame ${i}: ${position}`);
      tip(i).forEach((value, k) => assert.ok(Math.abs(rotation[k] - value) < 1e-5, `${stream} at frame ${i}: ${rotation}`));
    }
  }
});
