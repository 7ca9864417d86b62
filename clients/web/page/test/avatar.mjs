// Generates a VRM 1.0 avatar of boxes: one box per humanoid bone, 1.2 m tall. `picture`: bytes of a
// PNG for its texture. `presets`, `customs`: names of its expressions. `details`: it has an index
// finger, eyes, which bones turn, and a jaw.
const BONES = [
  ['hips', -1, 0, 0.7, 0], ['spine', 0, 0, 0.1, 0], ['chest', 1, 0, 0.12, 0], ['neck', 2, 0, 0.14, 0],
  ['head', 3, 0, 0.06, 0],
  ['leftUpperArm', 2, 0.12, 0.1, 0], ['leftLowerArm', 5, 0.18, 0, 0], ['leftHand', 6, 0.16, 0, 0],
  ['rightUpperArm', 2, -0.12, 0.1, 0], ['rightLowerArm', 8, -0.18, 0, 0], ['rightHand', 9, -0.16, 0, 0],
  ['leftUpperLeg', 0, 0.08, -0.04, 0], ['leftLowerLeg', 11, 0, -0.3, 0], ['leftFoot', 12, 0, -0.3, 0],
  ['rightUpperLeg', 0, -0.08, -0.04, 0], ['rightLowerLeg', 14, 0, -0.3, 0], ['rightFoot', 15, 0, -0.3, 0],
];

const RANGES = Object.fromEntries(['HorizontalInner', 'HorizontalOuter', 'VerticalDown', 'VerticalUp'].map((way) =>
  [`rangeMap${way}`, { inputMaxValue: 90, outputScale: 10 }]));
const DETAILS = [
  ['leftIndexProximal', 7, 0.08, 0, 0], ['leftIndexIntermediate', 17, 0.03, 0, 0],
  ['leftEye', 4, 0.03, 0.05, 0.05], ['rightEye', 4, -0.03, 0.05, 0.05], ['jaw', 4, 0, -0.02, 0.03],
];

export function makeAvatar(picture, { presets = [], customs = [], details = false } = {}) {
  const bones = details ? [...BONES, ...DETAILS] : BONES;
  const corners = [];
  for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) corners.push(0.045 * x, 0.045 * y, 0.045 * z);
  const faces = [0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3];
  const positions = Buffer.from(new Float32Array(corners).buffer);
  const indices = Buffer.from(new Uint16Array(faces).buffer);
  const texels = picture ?? Buffer.alloc(0);
  const binary = Buffer.concat([positions, indices, texels]);
  const nodes = bones.map(([name, , x, y, z], i) => {
    const children = bones.flatMap(([, parent], child) => (parent === i ? [child] : []));
    return { name, translation: [x, y, z], mesh: 0, ...(children.length > 0 ? { children } : {}) };
  });
  const json = {
    asset: { version: '2.0' },
    extensionsUsed: ['VRMC_vrm'],
    scene: 0,
    scenes: [{ nodes: [0] }],
    nodes,
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, material: 0 }] }],
    materials: [{ pbrMetallicRoughness: { baseColorFactor: [0.2, 0.9, 0.9, 1], metallicFactor: 0,
      ...(picture ? { baseColorTexture: { index: 0 } } : {}) } }],
    ...(picture ? { textures: [{ source: 0 }], images: [{ bufferView: 2, mimeType: 'image/png' }] } : {}),
    accessors: [
      { bufferView: 0, componentType: 5126, count: 8, type: 'VEC3', min: [-0.045, -0.045, -0.045], max: [0.045, 0.045, 0.045] },
      { bufferView: 1, componentType: 5123, count: 36, type: 'SCALAR' },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: positions.length },
      { buffer: 0, byteOffset: positions.length, byteLength: indices.length },
      ...(picture ? [{ buffer: 0, byteOffset: positions.length + indices.length, byteLength: texels.length }] : []),
    ],
    buffers: [{ byteLength: binary.length }],
    extensions: {
      VRMC_vrm: {
        specVersion: '1.0',
        meta: { name: 'Boxes', authors: ['the test'], licenseUrl: 'https://vrm.dev/licenses/1.0/' },
        humanoid: { humanBones: Object.fromEntries(bones.map(([name], node) => [name, { node }])) },
        expressions: { preset: Object.fromEntries(presets.map((name) => [name, {}])), custom: Object.fromEntries(customs.map((name) => [name, {}])) },
        ...(details ? { lookAt: { type: 'bone', ...RANGES } } : {}),
      },
    },
  };
  return glbOf(json, binary);
}

/** The bytes of a .glb with that JSON and that buffer. */
export function glbOf(json, binary) {
  const pad = (buffer, fill) => Buffer.concat([buffer, Buffer.alloc((4 - (buffer.length % 4)) % 4, fill)]);
  const chunk = (type, data) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(data.length, 0);
    head.write(type, 4, 'latin1');
    return Buffer.concat([head, data]);
  };
  const body = Buffer.concat([
    chunk('JSON', pad(Buffer.from(JSON.stringify(json)), 0x20)), chunk('BIN\0', pad(binary, 0)),
  ]);
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + body.length, 8);
  return Buffer.concat([head, body]);
}
