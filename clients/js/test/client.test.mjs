import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { create, toBinary } from '@bufbuild/protobuf';
import { Calibrate_Pose, Calibrate_Sensors, Code, NoAnswerError, Output, RefusedError, StatsSchema, StyledClient } from 'styled-client';

import { Gateway, body, frame, until } from '../test-support/gateway.mjs';

// Runs `play` with a gateway and a client, and always closes both.
async function together(play, options = {}) {
  const gateway = await Gateway.start();
  const client = new StyledClient({ url: gateway.url, timeout_ms: 2000, ...options });
  try {
    await play(gateway, client);
  } finally {
    client.close();
    await gateway.stop();
  }
}
const opened = (client) => until(() => client.linkState.kind === 'open', 'the link');

test('every frame arrives in order, with its body; what is missing is counted', () =>
  together(async (gateway, client) => {
    const updates = [];
    client.on('frame', (update) => updates.push(update));
    client.subscribe('rig.a');
    await until(() => gateway.topics.has('styled/rig.a/rig/'), 'the subscription');
    assert.ok(gateway.topics.has('body/rig.a/'));
    gateway.publish('styled/rig.a/rig/', frame(1));
    gateway.publish('body/rig.a/', body());
    for (const sequence of [2, 3, 6]) gateway.publish('styled/rig.a/rig/', frame(sequence));
    await until(() => updates.length === 4, 'four frames');
    assert.deepEqual(updates.map((u) => Number(u.frame.sequence)), [1, 2, 3, 6]);
    assert.deepEqual(updates.map((u) => u.missed), [0, 0, 0, 2]);
    assert.equal(updates[0].body, undefined);
    assert.deepEqual(updates[1].body.names, ['hips', 'head']);
    gateway.publish('styled/rig.a/rig/', frame(1, { epoch: 2n }));
    await until(() => updates.length === 5, 'a frame of the next epoch');
    assert.equal(updates[4].newEpoch, true);
    assert.equal(updates[4].missed, 0);
  }));

test('latest wins: one frame however many came, then none until another comes', () =>
  together(async (gateway, client) => {
    client.subscribeLatest('rig.a', 'source');
    await until(() => gateway.topics.has('source/rig.a/'), 'the subscription');
    gateway.publish('body/rig.a/', body());
    for (const sequence of [1, 2, 3, 5]) gateway.publish('source/rig.a/', frame(sequence));
    await until(() => client.arrived('rig.a', 'source') === 4, 'four frames');
    const first = client.latest('rig.a', 'source');
    assert.equal(first.frame.sequence, 5n);
    assert.equal(first.skipped, 3);
    assert.equal(client.latest('rig.a', 'source'), undefined);
    gateway.publish('source/rig.a/', frame(6));
    gateway.publish('source/rig.a/', frame(9));
    await until(() => client.arrived('rig.a', 'source') === 6, 'two more');
    const second = client.latest('rig.a', 'source');
    assert.deepEqual([second.frame.sequence, second.skipped, second.missed], [9n, 1, 2]);
  }));

test('a stream is subscribed to once, and let go with its last user', () =>
  together(async (gateway, client) => {
    await opened(client);
    const ends = [client.subscribe('rig.a'), client.subscribeLatest('rig.a')];
    await until(() => gateway.topics.size === 2, 'both topics');
    assert.equal(gateway.heard.filter((text) => text.includes('styled/rig.a/rig/')).length, 1);
    ends[0]();
    ends[0](); // twice is once
    client.subscribeStats();
    await until(() => gateway.topics.has('stats/'), 'stats');
    assert.ok(gateway.topics.has('styled/rig.a/rig/'));
    ends[1]();
    await until(() => gateway.topics.size === 1, 'the end');
  }));

test('what was subscribed to stays so over a broken connection', () =>
  together(async (gateway, client) => {
    const states = [];
    client.on('link', ({ kind }) => states.push(kind));
    client.subscribe('rig.a');
    client.subscribeStats();
    await until(() => gateway.topics.size === 3, 'topics');
    gateway.drop();
    await until(() => gateway.topics.size === 3, 'the same topics again');
    assert.ok(states.includes('connecting'));
    assert.equal(client.linkState.kind, 'open');
  }));

test('a gateway that starts later is found', async () => {
  const first = await Gateway.start();
  const { port, url } = first;
  await first.stop();
  const client = new StyledClient({ url });
  const reasons = [];
  client.on('link', (state) => reasons.push(state.reason));
  await until(() => reasons.includes(`no reply from ws://127.0.0.1:${port}/ws`), 'the reason');
  const second = await Gateway.start(port);
  await opened(client);
  client.close();
  await second.stop();
});

test('a refusal says why, and a token is shown', async () => {
  const gateway = await Gateway.start();
  gateway.token = 'abcdefgh12345678';
  const without = new StyledClient({ url: gateway.url });
  await until(() => without.linkState.kind === 'refused', 'the refusal');
  assert.match(without.linkState.reason, /token is missing/);
  assert.equal(without.linkState.status, 401);
  without.close();
  const withToken = new StyledClient({ url: gateway.url, token: gateway.token });
  await opened(withToken);
  withToken.close();
  await gateway.stop();
});

test('control: replies, refusals, silence', () =>
  together(async (gateway, client) => {
    await assert.rejects(client.list(), NoAnswerError); // not connected yet
    await opened(client);
    const requests = [];
    gateway.answer = (request) => {
      requests.push(request);
      return { code: Code.OK, applied: [{ performer: 'rig.a', firstSequence: 12n }] };
    };
    const applied = await client.set('rig.a', { strength: 0, parts: [1, 3] });
    assert.equal(applied[0].firstSequence, 12n);
    assert.equal(requests[0].performer, 'rig.a');
    assert.equal(requests[0].command.value.strength, 0); // 0 is present, not absent
    assert.equal(requests[0].command.value.transitionMs, undefined);
    assert.deepEqual(requests[0].command.value.parts, [1, 3]);
    await client.set('*', { vary: 7, varyEach: false, varyAmount: 0.5, driftS: 5 });
    const { vary, varyEach, varyAmount, driftS } = requests.pop().command.value;
    assert.deepEqual([vary, varyEach, varyAmount, driftS], [7, false, 0.5, 5]);
    await client.setStyle('*', 'elderly', 0.5);
    assert.equal(requests[1].command.value.mix[0].style, 'elderly');
    await client.preset('*', 'calm', 100);
    assert.equal(requests[2].command.case, 'preset');
    await client.panic();
    assert.equal(requests[3].command.case, 'panic');

    gateway.answer = () => ({ code: Code.UNKNOWN_STYLE, reason: 'no style pirate' });
    await assert.rejects(client.setStyle('rig.a', 'pirate'), (error) =>
      error instanceof RefusedError && error.code === Code.UNKNOWN_STYLE && /pirate/.test(error.message));
    gateway.answer = (request) => ({ notice: { unanswered: String(request.id), reason: 'no daemon' } });
    await assert.rejects(client.status(), (error) => error instanceof NoAnswerError && /no daemon/.test(error.message));
    gateway.answer = () => undefined;
    const lost = assert.rejects(client.reset('rig.a'), NoAnswerError);
    await until(() => requests.length >= 4, 'requests');
    gateway.drop();
    await lost;
  }));

test('cues and calibration', () =>
  together(async (gateway, client) => {
    await opened(client);
    const requests = [];
    gateway.answer = (request) => {
      requests.push(request);
      return request.command.case === 'calibrate'
        ? { code: Code.OK, calibrate: { worstJoint: 'leftHand', worstDegrees: 4 } }
        : { code: Code.OK, applied: [{ performer: 'rig.a', firstSequence: 5n }] };
    };
    assert.equal((await client.cue('act two'))[0].firstSequence, 5n);
    assert.equal((await client.calibrate('rig.a')).worstJoint, 'leftHand');
    await client.calibrate('rig.a', { pose: 'n', sensors: 'mounting' });
    await client.calibrate('rig.a', { clear: true });
    assert.deepEqual(requests.map(({ performer, command }) => [performer, command.case]),
      [['*', 'cue'], ['rig.a', 'calibrate'], ['rig.a', 'calibrate'], ['rig.a', 'calibrate']]);
    const [cue, usual, second, cleared] = requests.map(({ command }) => command.value);
    assert.equal(cue.name, 'act two');
    assert.deepEqual([usual.pose, usual.sensors, usual.clear], [Calibrate_Pose.T, Calibrate_Sensors.FULL, false]);
    assert.deepEqual([second.pose, second.sensors], [Calibrate_Pose.N, Calibrate_Sensors.MOUNTING]);
    assert.equal(cleared.clear, true);
    gateway.answer = () => ({ code: Code.UNKNOWN_CUE, reason: 'no cue "act ten"' });
    await assert.rejects(client.cue('act ten'), (error) => error.code === Code.UNKNOWN_CUE);
  }));

test('styles: examples, their files, previews; a take may last', () =>
  together(async (gateway, client) => {
    const asked = [];
    gateway.answer = (request) => {
      asked.push(request.command);
      switch (request.command.case) {
        case 'like':
        case 'importStyle':
          return { code: Code.OK, like: { name: 'mine', code: [1, 2] } };
        case 'exportStyle':
          return { code: Code.OK, styleFile: { name: 'mine', file: new TextEncoder().encode('{}') } };
        case 'preview':
          return { code: Code.OK, preview: { rateHz: 15, joints: 21, positionsMm: [1, -2, 3] } };
        default:
          return { code: Code.OK, applied: [{ performer: 'rig.a', firstSequence: 7n }] };
      }
    };
    await opened(client);
    const usual = await client.like('rig.a', { learnS: 2, measure: true });
    await client.like('rig.a', { name: 'mine', clip: new Uint8Array([103]), file: 'a.vrma', neutralCode: usual.code });
    assert.deepEqual(asked[1].value.neutralCode, [1, 2]);
    const { file } = await client.exportStyle('mine');
    assert.equal((await client.importStyle(file, { replace: true })).name, 'mine');
    assert.deepEqual([asked[3].value.name, asked[3].value.replace], ['', true]);
    assert.equal((await client.renameStyle('mine', 'yours'))[0].firstSequence, 7n);
    assert.equal((await client.removeStyle('yours'))[0].performer, 'rig.a');
    assert.deepEqual((await client.preview('old')).positionsMm, [1, -2, 3]);
    assert.deepEqual(asked.map((command) => command.case),
      ['like', 'like', 'exportStyle', 'importStyle', 'renameStyle', 'removeStyle', 'preview']);
  }));

test('a style by hand: what it begins with and its sliders; what was found of an example is in the reply', () =>
  together(async (gateway, client) => {
    const asked = [];
    gateway.answer = (request) => {
      asked.push(request);
      return request.command.case === 'list'
        ? { list: { sliders: [{ name: 'stoop', unit: 'degrees', least: -30, most: 60 }], designs: [{ name: 'sneaky', sliders: { stoop: 28 } }],
                    styles: [{ name: 'by-hand-rig-a', made: true, sliders: { stoop: 7 }, designable: true }] } }
        : { like: { name: 'by-hand-rig-a', found: ['walk: 7.2 strides'], weak: ['walk: only 2.1 s'] } };
    };
    await opened(client);
    const { styles, sliders, designs } = await client.list();
    assert.deepEqual([sliders[0].most, designs[0].sliders.stoop, styles[0].sliders.stoop, styles[0].designable], [60, 28, 7, true]);
    const reply = await client.design('rig.a', { sliders: { stoop: 28, energy: 0.5 } });
    assert.deepEqual([reply.found, reply.weak], [['walk: 7.2 strides'], ['walk: only 2.1 s']]);
    await client.design('', { name: 'mine', from: 'pirate', preset: 'sneaky', transitionMs: 500 });
    const [first, second] = asked.slice(1).map(({ performer, command: { case: what, value } }) => {
      assert.equal(what, 'like');
      return [performer, value.name, value.transitionMs, value.design.from, value.design.preset, value.design.sliders];
    });
    assert.deepEqual(first, ['rig.a', '', undefined, '', '', { stoop: 28, energy: 0.5 }]);
    assert.deepEqual(second, ['', 'mine', 500, 'pirate', 'sneaky', {}]);
    await client.like('rig.a', { name: 'mine', clip: new Uint8Array([103]), network: 'phase', add: true });
    assert.deepEqual([asked.at(-1).command.value.network, asked.at(-1).command.value.add], ['phase', true]);
    for (const [bad, text] of [[undefined, /found undefined as design, expected/], [{ slider: {} }, /found "slider" in the design, expected name, from/],
      [{ from: 3 }, /found 3 as from of the design, expected a string/], [{ sliders: 3 }, /found 3 as sliders of the design, expected \{ stoop/],
      [{ sliders: { stoop: '28' } }, /found "28" as slider stoop, expected a number/], [{ transitionMs: '1' }, /found "1" as transitionMs/]]) {
      await assert.rejects(client.design('rig.a', bad), (error) => error instanceof TypeError && text.test(error.message), String(text));
    }
    assert.equal(asked.length, 4);
  }));

test('the reply to a take is waited for as long as the take is', () =>
  together(async (gateway, client) => {
    await opened(client);
    gateway.answer = () => undefined;
    const begun = performance.now();
    await assert.rejects(client.like('rig.a', { name: 'x', learnS: 1 }), /no answer within 1200 ms/);
    assert.ok(performance.now() - begun > 1100);
  }, { long_ms: 200 }));

// The warnings on the console while `play` runs.
async function warnings(play) {
  const said = [], { warn } = console;
  console.warn = (text) => said.push(text);
  try {
    await play(said);
  } finally {
    console.warn = warn;
  }
}

test('a change that nobody will see is told: to who listens, else in the console', () =>
  together(async (gateway, client) => {
    await opened(client);
    gateway.answer = ({ performer }) => ({ code: Code.OK, like: { name: 'mine' }, applied:
      (performer === '*' ? ['rig.old', 'rig.a'] : [performer]).map((name) =>
        ({ performer: name, firstSequence: 5n, absent: name !== 'rig.a', noStrength: name === 'rig.a' })) });
    const absent = 'no performer of the name rig.ann is present: the change waits for it';
    const weak = 'the strength of rig.a is 0: no style is visible';
    await warnings(async (said) => {
      const [applied] = await client.setStyle('rig.ann', 'old');
      assert.deepEqual([applied.absent, applied.noStrength], [true, false]);
      await client.pin('rig.ann', true);
      assert.deepEqual(said, [`styled-client: ${absent}`]); // once until there is another one
      await client.set('rig.a', { mix: [{ style: 'old', weight: 1 }] });
      assert.deepEqual(said.slice(1), [`styled-client: ${weak}`]);
      const heard = [];
      client.on('unseen', (...args) => heard.push(args));
      await client.clear('rig.ann');
      await client.like('rig.ann', { name: 'mine', learnS: 1 });
      await client.preset('rig.a', 'calm');
      assert.deepEqual(heard, [[absent, 'rig.ann'], [absent, 'rig.ann'], [weak, 'rig.a']]);
      await client.setStyle('rig.a', 'old', 0); // as requested
      await client.set('*', { strength: 0 }); // no selected performer
      assert.deepEqual([heard.length, said.length], [3, 2]);
      gateway.answer = () => ({ code: Code.OK, applied: [
        { performer: 'rig.b', refused: 'rig.b: too strong' },
        { performer: 'rig.a', firstSequence: 5n, notVaried: 'giant' }] });
      await client.set('*', { vary: 7 });
      assert.deepEqual(heard.slice(3), [['not changed: rig.b: too strong', 'rig.b'],
        ['rig.a: giant has no variations and is shown as it is', 'rig.a']]);
    });
  }));

test('without listeners the console says who is not there, and what does not answer', async () => {
  await warnings(async (said) => {
    await together(async (gateway, client) => {
      gateway.onJoin = () => setTimeout(() => gateway.notice({ daemon: { up: true, reason: '' } }), 0);
      client.subscribe('rig.ann');
      await until(() => said.length, 'the warning');
      assert.match(said[0], /found no performer rig\.ann/);
    });
    const nobody = new StyledClient({ url: 'http://127.0.0.1:9' });
    await until(() => said.length > 1, 'the warning');
    await new Promise((resolve) => setTimeout(resolve, 600)); // another attempt: nothing more to say
    nobody.close();
    assert.deepEqual(said.slice(1), ['styled-client: no reply from ws://127.0.0.1:9/ws']);
  });
});

test('what TypeScript would refuse is refused in JavaScript too, before anything is sent', () =>
  together(async (gateway, client) => {
    await opened(client);
    let asked = 0;
    gateway.answer = () => {
      ++asked;
      return { code: Code.OK };
    };
    for (const [call, text] of [
      [() => client.set('rig.a', { strenght: 1 }), /found "strenght" in the change, expected mix, strength/],
      [() => client.set('rig.a', { strength: 'a' }), /found "a" as strength, expected a number/],
      [() => client.set('rig.a', { absolute: 1 }), /found 1 as absolute, expected a boolean/],
      [() => client.set('rig.a', { preset: 1 }), /found 1 as preset, expected a string/],
      [() => client.set('rig.a', { mix: { old: 1 } }), /as mix, expected a list/],
      [() => client.set('rig.a', { mix: [{ style: 'old' }] }), /found undefined as weight of old, expected a number/],
      [() => client.set('rig.a'), /found undefined as change, expected/],
      [() => client.setStyle('rig.a'), /found undefined as style of mix, expected a name/],
      [() => client.preset('rig.a', 3), /found 3 as preset, expected a name/],
      [() => client.cue(), /found undefined as cue, expected a name/],
    ]) {
      await assert.rejects(call(), (error) => error instanceof TypeError && text.test(error.message), `${call}`);
    }
    assert.throws(() => client.on('freme', () => {}), /found "freme" as event, expected link, daemon, frame/);
    await client.set('rig.a', { strength: 0.5, parts: [1], mix: [{ style: 'old', weight: 1 }], root: 1, vary: undefined });
    await client.clear('rig.a');
    assert.equal(asked, 2);
    assert.throws(() => new StyledClient(), /found undefined as options, expected/);
    for (const bad of ['a', NaN, -1, 0, Infinity]) {
      assert.throws(() => new StyledClient({ url: gateway.url, timeout_ms: bad }), /as timeout_ms, expected milliseconds above 0/);
    }
  }));

test('the example says what is wrong in a line above its usage', () => {
  const example = fileURLToPath(new URL('../example.mjs', import.meta.url));
  for (const [words, code, text] of [[['--help'], 0, ''], [['nonsense'], 2, 'found "nonsense" as address of styleweb, expected'],
    [['http://127.0.0.1:9', 'old', 'many'], 2, 'found "many", expected a number above 0'],
    [['http://127.0.0.1:9', 'old', '1', 'x'], 2, 'found "1 x", expected']]) {
    const { status, stdout, stderr } = spawnSync(process.execPath, [example, ...words], { encoding: 'utf8' });
    assert.equal(status, code, stderr);
    assert.ok(stderr.startsWith(text), stderr);
    assert.ok((stdout + stderr).endsWith('usage: node example.mjs [URL [STYLE [FRAMES]]]\n'), stderr);
    assert.equal((stdout + stderr).split('\n').length, code ? 3 : 2);
  }
});

test('what cannot be a name is said at once, and not sent', () =>
  together(async (gateway, client) => {
    await opened(client);
    let asked = 0;
    gateway.answer = () => {
      ++asked;
      return { code: Code.OK, calibrate: {} };
    };
    const aName = /found ".*" as performer, expected SOURCE\.NAME.*1 to 32 of A-Z a-z 0-9 _ -/;
    for (const name of ['', 'anna', 'rig.', '.anna', 'rig.a.b', 'rig.änna', 'rig.a/b', 'rig.a\n', `rig.${'a'.repeat(33)}`, undefined]) {
      for (const call of [() => client.setStyle(name, 'elderly'), () => client.clear(name), () => client.preset(name, 'x'),
                          () => client.pin(name, true), () => client.reset(name), () => client.calibrate(name)]) {
        await assert.rejects(call(), (error) => error instanceof TypeError && aName.test(error.message), name);
      }
      assert.throws(() => client.subscribe(name), aName);
      assert.throws(() => client.subscribeLatest(name, 'source'), aName);
    }
    assert.throws(() => client.subscribe('*'), aName); // a frame subscription needs one performer
    await assert.rejects(client.calibrate('*'), aName);
    assert.throws(() => client.subscribe('rig.a', 'Canonical'), /found "Canonical" as stream, expected rig, canonical, source/);
    await assert.rejects(client.calibrate('rig.a', { pose: 'sitting' }), /found "sitting" as pose, expected t, n/);
    await assert.rejects(client.calibrate('rig.a', { sensors: 'all' }), /expected full, yaw, mounting/);
    await client.reset('*');
    assert.equal(asked, 1);
    assert.deepEqual(gateway.heard, []);
  }));

test('a daemon that does not answer in time is an error, and what was asked may come about', () =>
  together(async (gateway, client) => {
    await assert.rejects(client.panic(), (error) => error instanceof NoAnswerError && !error.sent);
    await opened(client);
    await assert.rejects(client.panic(), (error) => /no answer within 50 ms/.test(error.message) && error.sent);
  }, { timeout_ms: 50 }));

test('how the daemon is comes from the gateway; without the gateway it is unknown', () =>
  together(async (gateway, client) => {
    const states = [];
    client.on('daemon', (state) => states.push(state.up));
    await opened(client);
    gateway.notice({ daemon: { up: true, reason: '' } });
    await until(() => client.daemonState.up, 'up');
    gateway.notice({ daemon: { up: false, reason: 'no daemon publishes at x' } });
    await until(() => !client.daemonState.up, 'down');
    assert.equal(client.daemonState.reason, 'no daemon publishes at x');
    gateway.notice({ daemon: { up: true, reason: '' } });
    await until(() => client.daemonState.up, 'up again');
    await gateway.stop();
    await until(() => !client.daemonState.up, 'unknown');
    assert.deepEqual(states.slice(0, 4), [true, false, true, false]);
  }));

test('damaged messages are complained about and harm nothing', () =>
  together(async (gateway, client) => {
    const complaints = [], frames = [], stats = [], bodies = [];
    client.on('complaint', (text) => complaints.push(text));
    client.on('frame', (update) => frames.push(update));
    client.on('stats', (value) => stats.push(value));
    client.on('body', (value) => bodies.push(value));
    client.subscribe('rig.a');
    client.subscribeStats();
    await until(() => gateway.topics.size === 3, 'topics');
    const bad = new Uint8Array([0xff, 0xff, 0xff]);
    gateway.publish('stats/', bad);
    gateway.publish('body/rig.a/', bad);
    gateway.publish('body/rig.a/', body({ parents: [-1, 1] }));
    gateway.publish('body/rig.a/', body({ offsets: [0, 1, 0] }));
    gateway.publish('body/rig.a/', body());
    gateway.publish('styled/rig.a/rig/', bad);
    gateway.publish('styled/rig.a/rig/', frame(1, { rotations: [0, 0, 0, 1] }));
    gateway.publish('styled/rig.a/rig/', frame(2, { rotations: [0, 0, 0, 0, 0, 0, 0, 1] }));
    gateway.publish('styled/rig.a/rig/', frame(3, { rootPosition: [0, NaN, 0] }));
    gateway.publish('', bad);
    gateway.publish('unknown/', bad);
    gateway.publish('styled/rig.a/rig/', frame(4));
    gateway.publish('stats/', toBinary(StatsSchema, create(StatsSchema, { epoch: 3n })));
    await until(() => stats.length === 1, 'good statistics');
    assert.deepEqual(frames.map((u) => u.frame.sequence), [4n]);
    assert.equal(bodies.length, 1);
    assert.equal(complaints.length, 9);
    assert.equal(client.linkState.kind, 'open');
  }));

test('bodies: replays are dropped, a change is told, both outputs are kept', () =>
  together(async (gateway, client) => {
    const bodies = [];
    client.on('body', (value) => bodies.push(value));
    client.subscribeBodies();
    await until(() => gateway.topics.has('body/'), 'the subscription');
    gateway.publish('body/rig.a/', body());
    gateway.publish('body/rig.a/', body());
    gateway.publish('body/rig.a/', body({ output: Output.CANONICAL, hash: 9n }));
    gateway.publish('body/rig.a/', body({ hash: 8n }));
    await until(() => bodies.length === 3, 'three bodies');
    assert.equal(client.body('rig.a', Output.RIG).hash, 8n);
    assert.equal(client.body('rig.a', Output.CANONICAL).hash, 9n);
    assert.equal(client.body('rig.b', Output.RIG), undefined);
  }));

test('both kinds of subscriber to one stream: each gets its own, with its own gaps', () =>
  together(async (gateway, client) => {
    const updates = [];
    client.on('frame', (update) => updates.push(update));
    client.subscribeLatest('rig.a');
    await until(() => gateway.topics.has('styled/rig.a/rig/'), 'the subscription');
    gateway.publish('body/rig.a/', body());
    gateway.publish('styled/rig.a/rig/', frame(1));
    await until(() => client.arrived('rig.a') === 1, 'a frame');
    assert.equal(client.latest('rig.a').frame.sequence, 1n);
    const end = client.subscribe('rig.a');
    for (const sequence of [4, 5, 7]) gateway.publish('styled/rig.a/rig/', frame(sequence));
    await until(() => updates.length === 3, 'each frame');
    assert.deepEqual(updates.map((u) => u.missed), [0, 0, 1]); // frames before its subscription are unknown
    const newest = client.latest('rig.a');
    assert.deepEqual([newest.frame.sequence, newest.missed, newest.skipped], [7n, 3, 2]);
    end();
    gateway.publish('styled/rig.a/rig/', frame(8));
    await until(() => client.arrived('rig.a') === 5, 'one more');
    assert.deepEqual([client.latest('rig.a').missed, updates.length], [0, 3]);
  }));

for (const url of ['no address', 'localhost:7080', 'tcp://127.0.0.1:7080', '']) {
  test(`an address that is none is an error at once: "${url}"`, () => {
    assert.throws(() => new StyledClient({ url }), (error) =>
      error.message.includes(`found "${url}"`) && /expected ws:\/\/.*http:\/\/127.0.0.1:7080/.test(error.message));
  });
}

test('a name that nobody bears is told once, and not of who is there, has left or is not asked for', () =>
  together(async (gateway, client) => {
    const complaints = [];
    const unknown = [];
    client.on('complaint', (text, name) => {
      complaints.push(text);
      unknown.push(name);
    });
    client.subscribe('rig.nobdoy');
    client.subscribeLatest('rig.nobdoy', 'source');
    await opened(client);
    gateway.notice({ daemon: { up: true, reason: '' } });
    await until(() => client.daemonState.up, 'the daemon');
    client.subscribe('rig.a');
    client.subscribe('rig.b')();
    gateway.publish('body/rig.a/', body());
    client.subscribe('rig.last'); // its turn comes after all others
    await until(() => complaints.some((text) => text.includes('rig.last')), 'the last complaint');
    assert.ok(client.body('rig.a', Output.RIG));
    assert.deepEqual(complaints.map((text) => /found no performer ([^,]+),/.exec(text)?.[1]), ['rig.nobdoy', 'rig.last']);
    assert.deepEqual(unknown, ['rig.nobdoy', 'rig.last']);
  }));

test('who is not reached is named, without the token', async () => {
  const gateway = await Gateway.start();
  await gateway.stop();
  const client = new StyledClient({ url: gateway.url, token: 'abcdefgh12345678' });
  const reasons = [];
  client.on('link', (state) => reasons.push(state.reason));
  await until(() => reasons.some((reason) => reason?.includes(`:${gateway.port}/ws`)), 'the address');
  client.close();
  assert.ok(!reasons.join().includes('abcdefgh'));
});
