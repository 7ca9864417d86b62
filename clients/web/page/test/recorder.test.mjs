// The recorder with the real client and a fake gateway that sends what a test specifies.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create, toBinary } from '@bufbuild/protobuf';
import { StatsSchema, StyledClient } from 'styled-client';

import { Gateway, body, frame, until } from '../../../js/test-support/gateway.mjs';
import { Recorder } from './dist/recorder.js';

const STREAMS = ['source/rig.a/', 'styled/rig.a/rig/'];

// Runs `play` while rig.a is recorded.
async function together(play, limits) {
  const gateway = await Gateway.start();
  const client = new StyledClient({ url: gateway.url });
  const recorder = new Recorder(client, limits);
  let ended;
  recorder.onEnd = (how) => (ended = how);
  const send = (...sequences) => {
    for (const sequence of sequences) for (const topic of STREAMS) gateway.publish(topic, frame(sequence));
  };
  const stats = (performers) =>
    gateway.publish('stats/', toBinary(StatsSchema, create(StatsSchema, { epoch: 1n, performers })));
  try {
    client.subscribeStats();
    await until(() => client.linkState.kind === 'open', 'the link');
    gateway.notice({ daemon: { up: true, reason: '' } });
    recorder.start('rig.a');
    await until(() => gateway.topics.has('styled/rig.a/rig/'), 'the subscription');
    gateway.publish('body/rig.a/', body());
    await play({ gateway, client, recorder, send, stats, ended: () => until(() => ended, 'the end').then(() => ended) });
  } finally {
    client.close();
    await gateway.stop();
  }
}

test('records both streams until it is stopped, and counts what did not arrive', () =>
  together(async ({ gateway, recorder, send, ended }) => {
    send(1, 2, 3, 6, 7);
    await until(() => recorder.frames === 5, 'frames');
    assert.equal(recorder.missed, 2);
    recorder.stop();
    const { take, reason } = await ended();
    assert.equal(reason, '');
    assert.deepEqual([take.source.length, take.styled.length, take.styled.missed], [5, 5, 2]);
    assert.deepEqual(take.body.names, ['hips', 'head']);
    assert.equal(recorder.recording, false);
    await until(() => !gateway.topics.has('styled/rig.a/rig/'), 'the end of the subscription');
  }));

test('the canonical humanoid is recorded, too', () =>
  together(async ({ gateway, recorder, send, ended }) => {
    await until(() => gateway.topics.has('styled/rig.a/canonical/'), 'the subscription');
    gateway.publish('body/rig.a/', body({ hash: 9n, output: 2 }));
    send(1, 2);
    await until(() => recorder.frames === 2, 'frames');
    for (const [sequence, bodyHash] of [[2, 9n], [3, 9n], [4, 10n]]) {
      gateway.publish('styled/rig.a/canonical/', frame(sequence, { bodyHash, output: 2 }));
    }
    send(3, 4);
    await until(() => recorder.frames === 4, 'more frames');
    recorder.stop();
    const { take } = await ended();
    assert.equal(take.canonical.track.length, 2); // one was of another body
  }));

test('a picture that is drawn meanwhile takes no frame away', () =>
  together(async ({ client, recorder, send }) => {
    client.subscribeLatest('rig.a');
    send(1, 2, 3);
    await until(() => client.latest('rig.a')?.frame.sequence === 3n, 'the newest');
    send(4);
    await until(() => recorder.frames === 4, 'all frames');
    assert.equal(recorder.missed, 0);
  }));

for (const [what, happen, reason] of [
  ['a daemon that goes away', ({ gateway }) => gateway.notice({ daemon: { up: false, reason: 'it is silent' } }), /daemon went away.*silent/],
  ['a gateway that goes away', ({ gateway }) => gateway.drop(), /^the connection to the gateway, styleweb, broke$/],
  ['a daemon that is a new one', ({ gateway }) => gateway.publish(STREAMS[1], frame(1, { epoch: 2n })), /restarted/],
  ['another skeleton', ({ gateway }) => {
    gateway.publish('body/rig.a/', body({ hash: 8n }));
    gateway.publish(STREAMS[1], frame(4, { bodyHash: 8n }));
  }, /another skeleton/],
  ['a performer who leaves', ({ stats }) => stats([{ performer: 'rig.b', live: true }]), /rig\.a left/],
  ['a performer who is silent for long', ({ stats }) => {
    for (let i = 0; i < 3; ++i) stats([{ performer: 'rig.a', live: false }]);
  }, /silent/],
]) {
  test(`${what} ends it, and what was got is kept`, () =>
    together(async (all) => {
      all.send(1, 2, 3);
      await until(() => all.recorder.frames === 3, 'frames');
      happen(all);
      const end = await all.ended();
      assert.match(end.reason, reason);
      assert.deepEqual([end.take.source.length, end.take.styled.length], [3, 3]);
    }));
}

test('a rig that stumbles is waited for', () =>
  together(async ({ recorder, send, stats }) => {
    const entry = (live) => [{ performer: 'rig.a', live }];
    send(1);
    for (const live of [false, false, true, false, false]) stats(entry(live));
    send(2);
    await until(() => recorder.frames === 2, 'the next frame');
    assert.equal(recorder.recording, true);
  }));

test('a recording has an end, in frames and in bytes', async () => {
  await together(async ({ send, ended }) => {
    send(1, 2, 3, 4);
    const { take, reason } = await ended();
    assert.match(reason, /^3 frames is the limit/);
    assert.equal(take.source.length, 3);
  }, { poses: 3, bytes: Infinity });
  await together(async ({ send, ended }) => {
    send(...Array.from({ length: 300 }, (_, i) => i));
    assert.match((await ended()).reason, /^257 frames is the limit/); // a second piece was begun
  }, { poses: Infinity, bytes: 60000 });
});

test('nothing came: there is no take', () =>
  together(async ({ recorder, ended }) => {
    recorder.stop();
    assert.equal((await ended()).take, undefined);
  }));
