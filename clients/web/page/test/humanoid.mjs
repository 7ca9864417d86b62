// The canonical humanoid (model/body/humanoid.h) with fingers, eyes and jaw, and takes of it.
import { Output } from 'styled-client';

import { Replay } from './dist/replay.js';
import { Track } from './dist/take.js';
import { makeBody, makeFrame, turn } from './support.mjs';

const JOINTS = [
  ['hips', -1, 0, 0.98, 0], ['spine', 0, 0, 0.13, 0], ['chest', 1, 0, 0.11, 0], ['neck', 2, 0, 0.19, 0], ['head', 3, 0, 0.08, 0.01],
  ['leftShoulder', 2, 0.05, 0.15, 0], ['leftUpperArm', 5, 0.1, 0, 0], ['leftLowerArm', 6, 0.27, 0, 0], ['leftHand', 7, 0.25, 0, 0],
  ['rightShoulder', 2, -0.05, 0.15, 0], ['rightUpperArm', 9, -0.1, 0, 0], ['rightLowerArm', 10, -0.27, 0, 0], ['rightHand', 11, -0.25, 0, 0],
  ['leftUpperLeg', 0, 0.09, -0.05, 0], ['leftLowerLeg', 13, 0, -0.42, 0], ['leftFoot', 14, 0, -0.42, 0], ['leftToes', 15, 0, -0.07, 0.13],
  ['rightUpperLeg', 0, -0.09, -0.05, 0], ['rightLowerLeg', 17, 0, -0.42, 0], ['rightFoot', 18, 0, -0.42, 0], ['rightToes', 19, 0, -0.07, 0.13],
];
const TAIL = [
  ['leftThumbMetacarpal', 8, 0.03, 0, 0.02], ['leftThumbProximal', 21, 0.03, 0, 0.02],
  ['leftIndexProximal', 8, 0.08, 0, 0.02], ['leftIndexIntermediate', 23, 0.03, 0, 0],
  ['leftEye', 4, 0.03, 0.06, 0.08], ['rightEye', 4, -0.03, 0.06, 0.08], ['jaw', 4, 0, 0.01, 0.03],
];

export function humanoid({ tail = true } = {}) {
  const joints = tail ? [...JOINTS, ...TAIL] : JOINTS;
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
