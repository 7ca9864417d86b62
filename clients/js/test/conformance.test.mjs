// Bodies and frames that every client must decode to the same numbers: tests/conformance/README.md.
//   STYLED_GOLDENS=tests/conformance node --test
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fromBinary, toJson } from '@bufbuild/protobuf';
import { BodySchema, FrameSchema, StyledClient, checkBody, checkFrame, worldTransforms } from 'styled-client';

import { Gateway, until } from '../test-support/gateway.mjs';

const folder = process.env.STYLED_GOLDENS;
const options = { skip: folder ? false : 'STYLED_GOLDENS is not set' };
const golden = (name) => JSON.parse(readFileSync(path.join(folder, `${name}.json`), 'utf8'));
const bytes = (hex) => new Uint8Array(Buffer.from(hex, 'hex'));

function assertFields(schema, message, expected) {
  const found = toJson(schema, message, {
    useProtoFieldName: true, alwaysEmitImplicit: true, enumAsInteger: true,
  });
  // The golden files contain booleans as numbers, like the wire.
  if (found.timecode) found.timecode.drop_frame = Number(found.timecode.drop_frame);
  for (const [name, value] of Object.entries(expected)) {
    assert.deepEqual(found[name] ?? null, value, name);
  }
}

for (const name of ['canonical', 'fifty-five-joints', 'centimetres', 'hand']) {
  test(`${name} is read to the same numbers`, options, () => {
    const expected = golden(name);
    const body = fromBinary(BodySchema, bytes(expected.body));
    assert.equal(checkBody(body), '');
    assertFields(BodySchema, body, expected.body_fields);
    assert.ok(expected.frames.length > 0);
    for (const entry of expected.frames) {
      const frame = fromBinary(FrameSchema, bytes(entry.frame));
      assert.equal(checkFrame(body, frame), '');
      assertFields(FrameSchema, frame, entry.fields);
      const { positions, rotations } = worldTransforms(body, frame);
      assert.equal(positions.length, 3 * entry.positions.length);
      const scale = Math.max(1, ...entry.positions.flat().map(Math.abs));
      entry.positions.flat().forEach((x, i) =>
        assert.ok(Math.abs(positions[i] - x) <= 1e-5 * scale, `${positions[i]} is not ${x}`));
      entry.rotations.forEach((expectedRotation, joint) => {
        const found = [...rotations.subarray(4 * joint, 4 * joint + 4)];
        const sign = Math.sign(found.reduce((sum, x, i) => sum + x * expectedRotation[i], 0));
        found.forEach((x, i) =>
          assert.ok(Math.abs(sign * x - expectedRotation[i]) <= 1e-5, `${found} is not ${expectedRotation}`));
      });
    }
  });
}

const refused = folder ? golden('refused') : { bodies: [], frames: [] };
for (const entry of [...refused.bodies, ...refused.frames]) {
  test(`refused: ${entry.why}`, async () => {
    const gateway = await Gateway.start();
    const client = new StyledClient({ url: gateway.url });
    const complaints = [], frames = [], bodies = [];
    client.on('complaint', (text) => complaints.push(text));
    client.on('frame', (update) => frames.push(update));
    client.on('body', (body) => bodies.push(body));
    try {
      client.subscribe('rig.anna');
      await until(() => gateway.topics.has('styled/rig.anna/rig/'), 'the subscription');
      if (entry.frame) {
        gateway.publish('body/rig.anna/', bytes(refused.body));
        gateway.publish('styled/rig.anna/rig/', bytes(entry.frame));
      } else {
        gateway.publish('body/rig.anna/', bytes(entry.body));
      }
      await until(() => complaints.length + frames.length > 0, 'a complaint');
      // A frame of another body is delivered: its own body may arrive later.
      assert.equal(frames.length, entry.why === 'of another body' ? 1 : 0);
      assert.equal(frames[0]?.body, undefined);
      assert.equal(bodies.length, entry.frame ? 1 : 0);
    } finally {
      client.close();
      await gateway.stop();
    }
  });
}
