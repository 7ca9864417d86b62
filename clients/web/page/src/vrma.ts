// Writes a take as a VRM animation (.vrma): VRMC_vrm_animation 1.0 in glTF 2.0. The nodes are the canonical
// humanoid, which stands in VRM's T-pose with all rotations 0, in VRM's axes and metres, so frames are copied
// as they are. Pinned by test/vrma.test.mjs, in which independent programs read it.
import { presetOf, type Body } from 'styled-client';

import { GlbWriter, type Gltf, type GltfNode, type Path } from './glb.js';
import type { Replay } from './replay.js';
import { Column, everyFrame } from './sampled.js';

const EYES = ['leftEye', 'rightEye'];
const NO_EXPRESSION = /^look(Up|Down|Left|Right)$/; // gaze belongs to lookAt

interface Gaze {
  node: number;
  eyes: number[]; // joints
  column: Column;
}

// The mean of rotations that are near to each other.
function mean(rotations: number[], joints: number[]): number[] {
  const sum = [0, 0, 0, 0];
  const first = joints[0]!;
  for (const joint of joints) {
    let dot = 0;
    for (let k = 0; k < 4; ++k) dot += rotations[4 * first + k]! * rotations[4 * joint + k]!;
    for (let k = 0; k < 4; ++k) sum[k]! += (dot < 0 ? -1 : 1) * rotations[4 * joint + k]!;
  }
  return sum;
}

// Nodes: a root at the origin, then the joints but the eyes. `nodes[joint]`: its node, or -1.
function skeletonOf(body: Body): { nodes: GltfNode[]; of: number[]; eyes: number[] } {
  const nodes: GltfNode[] = [{ name: 'root', children: [] }];
  const eyes: number[] = [], of: number[] = [];
  body.names.forEach((name, joint) => {
    of.push(EYES.includes(name) ? -1 : nodes.length);
    if (EYES.includes(name)) return void eyes.push(joint);
    nodes.push({ name, translation: body.offsets.slice(3 * joint, 3 * joint + 3) });
    const parent = nodes[joint === 0 ? 0 : of[body.parents[joint]!]!]!;
    (parent.children ??= []).push(nodes.length - 1);
  });
  return { nodes, of, eyes };
}

/** `replay` has the canonical humanoid. Expressions that the rig names like VRM's presets become these, others custom
ones. */
export async function vrmaOf(replay: Replay): Promise<Blob> {
  const { body, faceNames } = replay.canonical!;
  const { nodes, of, eyes } = skeletonOf(body);
  const add = (parent: number, node: GltfNode) => {
    nodes.push(node);
    (nodes[parent]!.children ??= []).push(nodes.length - 1);
    return nodes.length - 1;
  };
  const { frames } = replay;
  let gaze: Gaze | undefined;
  const head = of[body.names.indexOf('head')];
  if (eyes.length > 0 && head !== undefined) {
    const offset = [0, 1, 2].map((axis) => eyes.reduce((sum, joint) => sum + body.offsets[3 * joint + axis]!, 0) / eyes.length);
    gaze = { node: add(head, { name: 'lookAt', translation: offset }), eyes, column: new Column(4, frames) };
  }
  const hips = new Column(3, frames);
  const turns = body.names.map(() => new Column(4, frames));
  const face = new Map<string, Column>();
  for (const name of faceNames) {
    const meant = presetOf(name) ?? name;
    if (!NO_EXPRESSION.test(meant) && !face.has(meant)) face.set(meant, new Column(3, frames));
  }
  const times = await everyFrame(replay, ({ frame: { rootPosition, rotations, expressions } }) => {
    hips.add(rootPosition);
    turns.forEach((column, joint) => of[joint]! >= 0 && column.addRotation(rotations, 4 * joint));
    gaze?.column.addRotation(mean(rotations, gaze.eyes));
    const values = new Map<string, number>();
    for (const { name, value } of expressions) {
      const meant = presetOf(name) ?? name;
      values.set(meant, Math.max(values.get(meant) ?? 0, Math.min(1, value > 0 ? value : 0)));
    }
    for (const [name, column] of face) column.add([values.get(name) ?? 0, 0, 0]);
  });

  const channels: [number, Path, Float32Array][] = [[of[0]!, 'translation', hips.values]];
  turns.forEach((column, joint) => of[joint]! >= 0 && channels.push([of[joint]!, 'rotation', column.values]));
  if (gaze) channels.push([gaze.node, 'rotation', gaze.column.values]);
  const expressions = { preset: {} as Record<string, object>, custom: {} as Record<string, object> };
  for (const [name, { values }] of face) {
    const node = add(0, { name });
    expressions[presetOf(name) ? 'preset' : 'custom'][name] = { node };
    channels.push([node, 'translation', values]);
  }
  const humanBones = Object.fromEntries(body.names.flatMap((name, joint) => (of[joint]! >= 0 ? [[name, { node: of[joint] }]] : [])));
  const gltf: Gltf = {
    asset: { version: '2.0', generator: 'styled' },
    extensionsUsed: ['VRMC_vrm_animation'],
    scene: 0,
    scenes: [{ name: replay.take.performer, nodes: [0] }],
    nodes,
    extensions: {
      VRMC_vrm_animation: {
        specVersion: '1.0',
        humanoid: { humanBones },
        ...(face.size > 0 ? { expressions } : {}),
        ...(gaze ? { lookAt: { node: gaze.node, offsetFromHeadBone: nodes[gaze.node]!.translation } } : {}),
      },
    },
  };
  const writer = new GlbWriter(gltf);
  writer.animation(replay.take.performer, times, channels);
  return writer.file();
}
