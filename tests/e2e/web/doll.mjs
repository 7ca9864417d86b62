// An avatar for pictures of the documents: a VRM 1.0 figure of ellipsoids, 1.6 m tall, in a T-pose, facing +Z.
import { glbOf } from './avatar.mjs';

const MATERIALS = { skin: [0.93, 0.72, 0.58], shirt: [0.16, 0.5, 0.72], cloth: [0.17, 0.19, 0.27], hair: [0.24, 0.13, 0.09], dark: [0.03, 0.03, 0.04] };
// Bone, its parent, its place below the parent, and its ellipsoids: centre, radii (metres), material.
const side = (x) => [
  [x > 0 ? 'left' : 'right', 'UpperArm', 'chest', [0.17 * x, 0.19, 0], [[[0.12 * x, 0, 0], [0.14, 0.047, 0.047], 'shirt']]],
  [x > 0 ? 'left' : 'right', 'LowerArm', 'UpperArm', [0.25 * x, 0, 0], [[[0.11 * x, 0, 0], [0.13, 0.036, 0.036], 'skin']]],
  [x > 0 ? 'left' : 'right', 'Hand', 'LowerArm', [0.23 * x, 0, 0], [[[0.06 * x, 0, 0], [0.075, 0.022, 0.04], 'skin']]],
  [x > 0 ? 'left' : 'right', 'UpperLeg', 'hips', [0.085 * x, -0.04, 0], [[[0, -0.19, 0], [0.078, 0.22, 0.078], 'cloth']]],
  [x > 0 ? 'left' : 'right', 'LowerLeg', 'UpperLeg', [0, -0.38, 0], [[[0, -0.18, 0], [0.056, 0.21, 0.056], 'cloth']]],
  [x > 0 ? 'left' : 'right', 'Foot', 'LowerLeg', [0, -0.36, 0], [[[0, -0.03, 0.05], [0.048, 0.035, 0.115], 'hair']]],
].map(([which, name, parent, place, shapes]) => [which + name, /^[A-Z]/.test(parent) ? which + parent : parent, place, shapes]);
const BONES = [
  ['hips', '', [0, 0.84, 0], [[[0, 0.02, 0], [0.13, 0.11, 0.1], 'cloth']]],
  ['spine', 'hips', [0, 0.1, 0], [[[0, 0.06, 0], [0.12, 0.1, 0.09], 'shirt']]],
  ['chest', 'spine', [0, 0.14, 0], [[[0, 0.1, 0], [0.165, 0.15, 0.11], 'shirt']]],
  ['neck', 'chest', [0, 0.24, 0], [[[0, 0.03, 0], [0.042, 0.06, 0.042], 'skin']]],
  ['head', 'neck', [0, 0.07, 0], [[[0, 0.12, 0.01], [0.115, 0.14, 0.12], 'skin'], [[0, 0.165, -0.025], [0.125, 0.12, 0.125], 'hair'],
    [[0.042, 0.125, 0.118], [0.014, 0.022, 0.012], 'dark'], [[-0.042, 0.125, 0.118], [0.014, 0.022, 0.012], 'dark']]],
  ...side(1), ...side(-1),
];

const ACROSS = 24, UP = 14; // of a sphere's grid

function sphere() {
  const places = [], triangles = [];
  for (let j = 0; j <= UP; ++j) {
    for (let i = 0; i <= ACROSS; ++i) {
      const up = Math.PI * (j / UP - 0.5), around = 2 * Math.PI * i / ACROSS;
      places.push(Math.cos(up) * Math.sin(around), Math.sin(up), Math.cos(up) * Math.cos(around));
      const at = j * (ACROSS + 1) + i, above = at + ACROSS + 1;
      if (j < UP && i < ACROSS) triangles.push(at, at + 1, above + 1, at, above + 1, above);
    }
  }
  return { places: Buffer.from(new Float32Array(places).buffer), triangles: Buffer.from(new Uint16Array(triangles).buffer) };
}

/** The bytes of the .vrm. */
export function makeDoll() {
  const names = Object.keys(MATERIALS), { places, triangles } = sphere();
  const shapes = BONES.flatMap(([bone, , , all]) => all.map(([translation, scale, material]) => ({ bone, translation, scale, mesh: names.indexOf(material) })));
  const nodes = [
    ...BONES.map(([name, , translation]) => ({ name, translation, children: [
      ...BONES.flatMap(([, parent], i) => (parent === name ? [i] : [])), ...shapes.flatMap(({ bone }, i) => (bone === name ? [BONES.length + i] : []))] })),
    ...shapes.map(({ translation, scale, mesh }) => ({ translation, scale, mesh })),
  ];
  const count = places.length / 12;
  const json = {
    asset: { version: '2.0' }, extensionsUsed: ['VRMC_vrm'], scene: 0, scenes: [{ nodes: [0] }], nodes,
    meshes: names.map((_, material) => ({ primitives: [{ attributes: { POSITION: 0, NORMAL: 0 }, indices: 1, material }] })),
    materials: names.map((name) => ({ name, pbrMetallicRoughness: { baseColorFactor: [...MATERIALS[name], 1], metallicFactor: 0, roughnessFactor: 0.8 } })),
    accessors: [{ bufferView: 0, componentType: 5126, count, type: 'VEC3', min: [-1, -1, -1], max: [1, 1, 1] },
      { bufferView: 1, componentType: 5123, count: triangles.length / 2, type: 'SCALAR' }],
    bufferViews: [{ buffer: 0, byteOffset: 0, byteLength: places.length }, { buffer: 0, byteOffset: places.length, byteLength: triangles.length }],
    buffers: [{ byteLength: places.length + triangles.length }],
    extensions: { VRMC_vrm: { specVersion: '1.0', meta: { name: 'Doll', authors: ['the Styled authors'], licenseUrl: 'https://vrm.dev/licenses/1.0/' },
      humanoid: { humanBones: Object.fromEntries(BONES.map(([name], node) => [name, { node }])) }, expressions: {} } },
  };
  return glbOf(json, Buffer.concat([places, triangles]));
}
