// Messages for files that are not avatars.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { unreadable, vrmFault } from './dist/vrm_file.js';

const REQUIRED = ['hips', 'spine', 'head', ...['left', 'right'].flatMap((side) =>
  ['UpperArm', 'LowerArm', 'Hand', 'UpperLeg', 'LowerLeg', 'Foot'].map((bone) => side + bone))];

function binary(json, { length, version = 2 } = {}) {
  let text = typeof json === 'string' ? json : JSON.stringify(json);
  text = text.padEnd(Math.ceil(text.length / 4) * 4);
  const bytes = Buffer.alloc(20 + text.length);
  bytes.write('glTF', 0, 'latin1');
  [version, length ?? bytes.length, text.length].forEach((value, i) => bytes.writeUInt32LE(value, 4 + 4 * i));
  bytes.write('JSON', 16, 'latin1');
  bytes.write(text, 20);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
}
const vrm1 = (bones) => ({ extensions: { VRMC_vrm: { humanoid: { humanBones: Object.fromEntries(bones.map((bone) => [bone, { node: 0 }])) } } } });
const vrm0 = (bones) => ({ extensions: { VRM: { humanoid: { humanBones: bones.map((bone) => ({ bone, node: 0 })) } } } });

test('a whole humanoid of either version is let through', () => {
  for (const of of [vrm0, vrm1]) assert.equal(vrmFault('a.vrm', binary(of(REQUIRED))), '');
});

for (const [what, bytes, said] of [
  ['nothing', new ArrayBuffer(0), /is not a VRM file/],
  ['another file', new TextEncoder().encode('a text about avatars and nothing else').buffer, /is not a VRM file/],
  ['glTF of old', binary({}, { version: 1 }), /version 1/],
  ['a file cut short', binary(vrm1(REQUIRED), { length: 9999 }), /is not complete: it has \d+ of 9999 bytes/],
  ['a damaged description', binary('{"asset": '), /not JSON.*\(.*JSON.*\)$/],
  ['a description that is null', binary('null'), /not a VRM avatar/],
  ['glTF of a chair', binary({ asset: { version: '2.0' } }), /not a VRM avatar/],
  ['a humanoid without bones', binary({ extensions: { VRMC_vrm: { humanoid: {} } } }), /not a VRM avatar/],
  ['a humanoid without a foot', binary(vrm1(REQUIRED.slice(0, -1))), /it has no rightFoot;/],
]) {
  test(`${what} is named, with what was expected`, () => {
    const fault = vrmFault('mine.vrm', bytes);
    assert.match(fault, /^mine\.vrm .*expected a VRM 0\.x or 1\.0 avatar/);
    assert.match(fault, said);
  });
}

test("a library's words stand in brackets at the end", () => {
  assert.match(unreadable('mine.vrm', new RangeError('Invalid typed array length: 5')),
    /^mine\.vrm cannot be read.*expected a VRM.*\(Invalid typed array length: 5\)$/);
});
