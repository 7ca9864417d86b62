// The times of poses, and what fills the gaps between them.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Track, TrackReader, causesInWords, causesOf, filledIn, gridOf, posesOn } from './dist/take.js';
import { makeBody, makeFrame, randomOf, turn } from './support.mjs';

const body = makeBody();
const ns = (seconds) => BigInt(Math.round(seconds * 1e9));

// [sequence, the rig's time (s), the daemon's time (s)]; the root's x is the time.
function trackOf(moments) {
  const track = new Track(body.names.length);
  for (const [sequence, rig_s, daemon_s = rig_s + 5] of moments) {
    track.add(makeFrame(body, sequence, {
      sourceTimeNs: ns(rig_s), receiveTimeNs: ns(daemon_s), rootPosition: [rig_s, 1, 0],
    }));
  }
  return track;
}
const range = (count) => [...Array(count).keys()];
const spread = (grid, track) => [...posesOn(grid, 0, track)].map(([x]) => x);

test('what came evenly stays as it came', () => {
  const track = trackOf(range(600).map((i) => [i, 1000 + i / 120]));
  const grid = gridOf([track]);
  assert.deepEqual([grid.rate_hz, grid.first, grid.frames, filledIn(grid, 0), track.missed], [120, 0, 600, 0, 0]);
  [...posesOn(grid, 0, track)].forEach((pose, i) => assert.deepEqual(pose, track.pose(i)));
});

test('frames that did not arrive are filled in between their neighbors, and counted', () => {
  const gone = new Set([3, 4, 5, 100]);
  const track = trackOf(range(200).filter((i) => !gone.has(i)).map((i) => [i, i / 120]));
  const grid = gridOf([track]);
  assert.deepEqual([grid.rate_hz, grid.frames, filledIn(grid, 0), track.missed], [120, 200, 4, 4]);
  spread(grid, track).forEach((x, i) => assert.ok(Math.abs(x - i / 120) < 1e-6, `${x} in frame ${i}`));
});

test('frames that the rig lost leave no gap in the sequence; time tells', () => {
  const times = range(200).filter((i) => i !== 50 && i !== 51).map((i) => i / 60);
  const track = trackOf(times.map((time_s, i) => [i, time_s]));
  const grid = gridOf([track]);
  assert.deepEqual([grid.rate_hz, grid.frames, filledIn(grid, 0), track.missed], [60, 200, 2, 0]);
  spread(grid, track).forEach((x, i) => assert.ok(Math.abs(x - i / 60) < 1e-6));
});

test('why there is no pose: by the numbers of the daemon and of the rig, and by time alone', () => {
  // A rig with two performers that numbers all frames in one sequence, at 100 Hz.
  const track = new Track(body.names.length);
  let sequence = 0;
  for (const i of range(300)) {
    if (i === 40 || i === 41) continue; // numbered by the rig, not published by the daemon
    const late = i >= 200 ? 3 : 0; // the rig pauses, and its numbers continue
    ++sequence;
    if ([100, 101, 102, 103, 296].includes(i)) continue; // published, not received
    track.add(makeFrame(body, sequence, {
      sourceSequence: BigInt(70 + 2 * i), sourceTimeNs: ns((i + late) / 100), receiveTimeNs: ns(5 + (i + late) / 100),
    }));
  }
  const grid = gridOf([track]);
  const causes = causesOf(grid, 0, track);
  assert.deepEqual(causes, { unreached: 5, unpublished: 2, unnumbered: 3 });
  assert.equal(filledIn(grid, 0), 10);
  assert.match(causesInWords(causes), /^5 did not reach this page; 2 never left the daemon: lost on the way .* too late; 3 where/);
  // Gaps outside the file are not counted.
  const early = { ...grid, frames: 60 }; // of the rig's steps: step is 1
  assert.deepEqual(causesOf(early, 0, track), { unreached: 0, unpublished: 2, unnumbered: 0 });
});

test('without numbers of the rig no cause is made up', () => {
  const times = range(200).filter((i) => i !== 50 && i !== 51).map((i) => i / 60);
  const track = trackOf(times.map((time_s, i) => [i, time_s]));
  assert.deepEqual(causesOf(gridOf([track]), 0, track), { unreached: 0, unpublished: 0, unnumbered: 2 });
  assert.doesNotMatch(causesInWords({ unreached: 0, unpublished: 0, unnumbered: 2 }), /daemon|page/);
});

test('a joint is turned on between its neighbors, the short way', () => {
  const track = new Track(body.names.length);
  const about = (degrees, sign) =>
    body.names.flatMap(() => turn([0, 1, 0], degrees * Math.PI / 180).map((x) => sign * x));
  for (const [i, degrees, sign] of [[0, 0, 1], [1, 10, 1], [2, 20, 1], [6, 60, -1], [7, 70, 1]]) {
    track.add(makeFrame(body, i, { rotations: about(degrees, sign) }));
  }
  const grid = gridOf([track]);
  assert.equal(filledIn(grid, 0), 3);
  [...posesOn(grid, 0, track)].forEach((pose, i) => {
    const dot = turn([0, 1, 0], 10 * i * Math.PI / 180).reduce((sum, x, k) => sum + x * pose[3 + k], 0);
    assert.ok(Math.abs(Math.abs(dot) - 1) < 1e-6, `frame ${i}`);
  });
});

test('jitter moves no pose, and time is true to the end', () => {
  const random = randomOf(2);
  const track = trackOf(range(3600).map((i) => [i, (i + 0.6 * (random() - 0.5)) / 60]));
  const grid = gridOf([track]);
  assert.deepEqual([grid.frames, filledIn(grid, 0)], [3600, 0]);
  assert.ok(Math.abs(grid.frames / grid.rate_hz - 60) < 0.03);
});

test('rates: one of NTSC, and one that is nearly but not quite a whole one', () => {
  const rateOf = (count, rate_hz) => gridOf([trackOf(range(count).map((i) => [i, i / rate_hz]))]).rate_hz;
  assert.ok(Math.abs(rateOf(3000, 30000 / 1001) - 30000 / 1001) < 1e-9);
  assert.equal(rateOf(1000, 60.001), 60); // less than half a frame
  assert.ok(Math.abs(rateOf(1000, 110.3) - 110.3) < 1e-3, 'no usual rate is near');
});

test('a rig that keeps its rate only nearly has a file of the nominal one, and true to its end', () => {
  for (const [rate_hz, meant_hz] of [[119.99, 120], [119.2, 120], [59.4, 60], [60.9, 60], [29.9, 30]]) {
    const count = 20 * 60 * 10;
    const track = trackOf(range(count).map((i) => [i, i / rate_hz]));
    const grid = gridOf([track]);
    assert.equal(grid.rate_hz, meant_hz);
    const whole_s = (count - 1) / rate_hz;
    assert.ok(Math.abs((grid.frames - 1) / meant_hz - whole_s) < 1 / meant_hz, `${grid.frames} frames for ${whole_s} s`);
    assert.equal(filledIn(grid, 0), 0);
    spread(grid, track).forEach((x, i) => assert.ok(Math.abs(x - i / meant_hz) < 1e-3 * whole_s / 60 + 1e-4, `${x} in frame ${i}`));
  }
});

test('a long take of such a rig is true to its end, too', () => {
  const count = 200000, rate_hz = 119.99; // 17 frames fewer than at the nominal rate
  const grid = gridOf([trackOf(range(count).map((i) => [i, i / rate_hz]))]);
  assert.equal(grid.rate_hz, 120);
  assert.ok(Math.abs((grid.frames - 1) / 120 - (count - 1) / rate_hz) < 1 / 120, `${grid.frames} frames for ${count / rate_hz} s`);
  assert.ok(Math.abs(grid.step * grid.rate_hz - rate_hz) < 1e-6, `${grid.step * grid.rate_hz} Hz`);
  assert.equal(filledIn(grid, 0), 0);
});

test('what was lost of such a rig is counted in its own frames', () => {
  const gone = new Set([30, 31, 32]);
  const track = trackOf(range(600).filter((i) => !gone.has(i)).map((i) => [i, i / 59.5]));
  const grid = gridOf([track]);
  assert.deepEqual([grid.rate_hz, filledIn(grid, 0)], [60, 3]);
  assert.deepEqual(causesOf(grid, 0, track), { unreached: 3, unpublished: 0, unnumbered: 0 });
});

test('a face and contacts stay with their pose', () => {
  const track = new Track(body.names.length);
  const face = (...values) => values.map(([name, value]) => ({ name, value }));
  track.add(makeFrame(body, 1, { contacts: 1, expressions: face(['Joy', 0.5]) }));
  track.add(makeFrame(body, 2, { contacts: 2 }));
  track.add(makeFrame(body, 5, { contacts: 3, expressions: face(['A', 0.25], ['Joy', 1]) }));
  assert.deepEqual([0, 1, 2].map((i) => track.contacts(i)), [1, 2, 3]);
  assert.deepEqual(track.face(0), face(['Joy', 0.5]));
  assert.deepEqual(track.face(1), []);
  assert.deepEqual(track.face(2), face(['Joy', 1], ['A', 0.25]));
  const reader = new TrackReader(track, [0, 1, 4]);
  assert.deepEqual([0, 0.5, 1, 2, 3.9, 4].map((place) => reader.index(place)), [0, 0, 1, 1, 1, 2]);
});

test('where the clock of the rig stands still or begins anew, that of the daemon counts', () => {
  const still = trackOf(range(100).map((i) => [i, 0, i / 50]));
  assert.deepEqual([gridOf([still]).rate_hz, gridOf([still]).frames], [50, 100]);
  for (const [before_s, after_s] of [[1e6, 0], [0, 1e6]]) {
    const anew = trackOf(range(100).map((i) => [i, (i < 50 ? before_s : after_s) + i / 50, 3 + i / 50]));
    assert.deepEqual([gridOf([anew]).rate_hz, gridOf([anew]).frames], [50, 100]);
  }
});

test('input and styled motion are cut to what both have, and stay beside each other', () => {
  const source = trackOf(range(100).filter((i) => i !== 20).map((i) => [i, i / 120]));
  const styled = trackOf(range(100).filter((i) => i >= 2).map((i) => [i, i / 120]));
  const grid = gridOf([source, styled]);
  assert.deepEqual([grid.first, grid.frames, filledIn(grid, 0), filledIn(grid, 1)], [2, 98, 1, 0]);
  const [a, b] = [[...posesOn(grid, 0, source)], [...posesOn(grid, 1, styled)]];
  assert.equal(a.length, 98);
  b.forEach((pose, i) => assert.ok(Math.abs(pose[0] - a[i][0]) < 1e-6));
});

test('a frame that comes twice or late is not taken; one pose alone makes no grid', () => {
  const track = trackOf([[5, 1], [5, 1], [4, 0.9]]);
  assert.equal(track.length, 1);
  assert.equal(gridOf([track]), undefined);
  assert.equal(gridOf([trackOf([]), trackOf([[1, 0], [2, 1]])]), undefined);
});
