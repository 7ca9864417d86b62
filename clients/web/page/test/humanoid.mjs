// The canonical humanoid (model/body/humanoid.h) with fingers, eyes and jaw, and takes of it.
import { Output } from 'styled-client';

import { HUMANOID } from '../../../js/test-support/humanoid.mjs';
import { Replay } from './dist/replay.js';
import { Track } from './dist/take.js';
import { makeBody, makeFrame, turn } from './support.mjs';

const TAIL = [
  ['leftThumbMetacarpal', 8, 0.03, 0, 0.02], ['leftThumbProximal', 21, 0.03, 0, 0.02],
  ['leftIndexProximal', 8, 0.08, 0, 0.02], ['leftIndexIntermediate', 23, 0.03, 0, 0],
  ['leftEye', 4, 0.03, 0.06, 0.08], ['rightEye', 4, -0.03, 0.06, 0.08], ['jaw', 4, 0, 0.01, 0.03],
];

export function humanoid({ tail = true } = {}) {
  const joints = tail ? [...HUMANOID, ...TAIL] : HUMANOID;
  return makeBody({
    names: joints.map(([name]) => name), parents: joints.map(([, parent]) => parent),
    offsets: joints.flatMap(([, , ...offset]) => offset), output: Output.CANONICAL, hash: 8n,
  });
}

/** Frame i of a performer who walks in a curve, and turns every joint about another axis. */
export function frameOf(body, i, fields = {}) {
  const t = i / 60;
  const rotations = body.names.flatMap((name, joint) => {
    const swing = (/Eye$/.test(name) ? 0.2 : 0.5) * Math.sin(3 * t + joint);
    return turn(joint === 0 ? [0, 1, 0] : [Math.sin(joint), Math.cos(2 * joint), Math.cos(joint)], joint === 0 ? t : swing);
  });
  return makeFrame(body, i, {
    sourceTimeNs: BigInt(Math.round((i * 1e9) / 60)), receiveTimeNs: BigInt(Math.round((i * 1e9) / 60)),
    rootPosition: [0.7 * t, 0.95 + 0.02 * Math.sin(9 * t), 0.4 * t * t], rotations, output: Output.CANONICAL, ...fields,
  });
}

/** A take of `count` frames at 60 Hz, to be played; `fields(i)`: what else frame i has. */
export function replayOf(body, count, fields = () => ({})) {
  const rig = makeBody();
  const [source, styled, track] = [rig, rig, body].map((of) => {
    const track = new Track(of.names.length);
    for (let i = 0; i < count; ++i) {
      const { sourceTimeNs, receiveTimeNs } = frameOf(body, i);
      track.add(of === body ? frameOf(body, i, fields(i)) : makeFrame(rig, i, { sourceTimeNs, receiveTimeNs }));
    }
    return track;
  });
  return Replay.of({ performer: 'rig.a', body: rig, begun: new Date(), source, styled, canonical: { body, track } });
}
