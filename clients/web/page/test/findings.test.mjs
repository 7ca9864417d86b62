// The page's messages about a silent rig.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { PerformerStatsSchema, StatsSchema } from 'styled-client';

import { findings, neutralWords, strays } from './dist/findings.js';

const stats = (sources, counters = {}, epoch = 1n) =>
  create(StatsSchema, {
    epoch, sources: Object.entries(sources).map(([name, received]) => ({ name, type: 'vmc', listen: 'udp://0.0.0.0:39539', received: BigInt(received) })),
    counters: Object.entries(counters).map(([name, value]) => ({ name, value: BigInt(value) })),
  });

test('no source, and sources that nothing reaches', () => {
  assert.match(findings(stats({}), undefined)[0], /^No source is configured/);
  const [only] = findings(stats({ stage: 0 }), undefined);
  assert.match(only, /^stage \(vmc, udp:\/\/0\.0\.0\.0:39539\): nothing has ever arrived\..*firewall/);
});

test('phones, sources that ask a server, and devices are told what they lack', () => {
  const one = (type, received = 0, fields = {}) => create(StatsSchema, {
    epoch: 1n, sources: [{ name: 'it', type, listen: '', received: BigInt(received) }], ...fields });
  const silent = (type) => findings(one(type), undefined)[0];
  assert.match(silent('livelinkface'), /^it \(livelinkface\): nothing has ever arrived\. Does the app on the phone name this machine/);
  assert.match(silent('ifacialmocap'), /asks the phone, which has never answered\..*server of this source/);
  assert.match(silent('natnet'), /asks Motive, which has never answered\..*server of this source/);
  assert.match(silent('slimevr-usb'), /plugged in/);
  for (const type of ['ifacialmocap', 'natnet', 'usb', 'slimevr-usb']) assert.doesNotMatch(silent(type), /send to this machine/);
  assert.match(findings(one('livelinkface', 60), one('livelinkface', 60))[0], /60 datagrams arrived, none of them now\. Is the app on the phone open/);
});

test('a phone that sends is no reason for silence: its face waits for a body', () => {
  const of = (phone, stage, layers = []) => create(StatsSchema, { epoch: 1n, performers: [{ performer: 'stage.anna', layers }], sources: [
    { name: 'phone', type: 'livelinkface', received: BigInt(phone), mergeInto: '*' }, { name: 'glove', type: 'vmc', received: BigInt(phone) },
    { name: 'stage', type: 'mvn', received: BigInt(stage) }] });
  const layers = [{ source: 'glove', part: 'fingers', live: true }];
  const found = findings(of(160, 5, layers), of(100, 5, layers));
  assert.deepEqual(found.map((text) => text.split(' ')[0]), ['stage', 'phone', 'glove']);
  assert.match(found[1], /60 datagrams arrived in the last second: a face, which waits for the body/);
  assert.match(found[2], /: fingers, which waits? for the body/);
});

test('a phone that is a performer by itself waits for no body', () => {
  const of = (count) => create(StatsSchema, { epoch: 1n, counters: [{ name: 'source.incomplete', value: BigInt(count) }],
    sources: [{ name: 'phone', type: 'livelinkface', received: BigInt(count) }] });
  const [found] = findings(of(160), of(100));
  assert.match(found, /60 datagrams arrived in the last second, but no pose: a phone sees no face/);
});

test('data that reach no performer, as the daemon explains it', () => {
  const now = create(StatsSchema, { sources: [{ name: 'stage', type: 'mvn' },
    { name: 'phone', type: 'livelinkface', stray: 'its data are for stage.anna, who is not here; here is stage.ben' }] });
  assert.deepEqual(strays(now), ['phone (livelinkface): its data are for stage.anna, who is not here; here is stage.ben.']);
  assert.deepEqual(strays(create(StatsSchema, {})), []);
});

test('datagrams that are no poses, with what they are counted as', () => {
  const before = stats({ stage: 100 }, { 'source.malformed': 100, 'source.received': 100 });
  const found = findings(stats({ stage: 160 }, { 'source.malformed': 160, 'source.received': 160 }), before);
  assert.deepEqual(found.length, 1);
  assert.match(found[0], /: 60 datagrams arrived in the last second, but no pose: they are not what .* \(source\.malformed\)\.$/);
  // Counted as nothing in particular.
  assert.match(findings(stats({ stage: 160 }), stats({ stage: 100 }))[0], /but no pose: stylectl doctor stage looks into them\.$/);
});

test('a message of control that is refused is no reason why a source has no pose', () => {
  const before = stats({ stage: 100 }, { 'control.malformed': 5 });
  const found = findings(stats({ stage: 160 }, { 'control.malformed': 95 }), before);
  assert.deepEqual(found, [
    'stage (vmc, udp://0.0.0.0:39539): 60 datagrams arrived in the last second, but no pose: stylectl doctor stage looks into them.']);
});

test('while two sources talk, counters of the whole daemon say nothing of either; of one that talks they do', () => {
  const before = stats({ a: 100, b: 100 }, { 'source.malformed': 100 });
  const both = findings(stats({ a: 160, b: 130 }, { 'source.malformed': 160 }), before);
  assert.equal(both.length, 2);
  both.forEach((text) => assert.match(text, /^([ab]) .* datagrams arrived in the last second, but no pose: stylectl doctor \1 looks into them\.$/));
  const [one, other] = findings(stats({ a: 160, b: 100 }, { 'source.malformed': 160 }), before);
  assert.match(one, /^a .*but no pose: they are not what .* \(source\.malformed\)\.$/);
  assert.match(other, /^b .*none of them now/);
});

test('a rig that stopped; statistics of another daemon are not compared', () => {
  assert.match(findings(stats({ stage: 160 }), stats({ stage: 160 }))[0], /160 datagrams arrived, none of them now/);
  assert.match(findings(stats({ stage: 160 }, {}, 2n), stats({ stage: 100 }))[0], /160 datagrams arrived, none of them now/);
});

test('of many sources those that speak come first', () => {
  const names = { a: 0, b: 5, c: 0, d: 9, e: 0 };
  const found = findings(stats({ ...names, d: 12 }), stats(names));
  assert.deepEqual(found.map((text) => text.split(' ')[0]), ['d', 'b', 'a', '2']);
  assert.match(found.at(-1), /^2 more sources/);
});

test('while a style is shown, how well its performer is known', () => {
  const words = (neutral, fields = {}) => neutralWords(create(PerformerStatsSchema, { live: true, turnedDeg: 3, neutral, ...fields }));
  assert.equal(words({ learned: 0.4 }), ' · learned 40 %');
  assert.equal(words({ learned: 0.9 }), '');
  assert.equal(words({ learned: 0.4, calibrated: true }), '');
  assert.equal(words({ learned: 0, calibratesS: 3.2 }), ' · shows their walk: 4 s');
  assert.equal(words({ learned: 0.4 }, { turnedDeg: undefined }), '', 'nothing is styled');
  assert.equal(words({ learned: 0.4 }, { live: false }), '');
  assert.equal(words(undefined), '', 'weights without a reference');
});
