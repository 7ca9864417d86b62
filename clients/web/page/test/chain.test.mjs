// The row of links from the rig to the page: for each fault the link that shows it, and what cures it.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { StatsSchema } from 'styled-client';

import { chainOf } from './dist/chain.js';

const well = {
  performer: 'stage.anna', live: true, rateHz: 120, joints: 23, dialect: 'mvn', neutral: { learned: 1 },
  look: { strength: 1, mix: [{ style: 'elderly', weight: 1 }] }, moved: { head: 9, hands: 12, elbows: 4, knees: 5, feet: 3 },
};
const stats = (performer, { received = 1000, counters = {}, sources = [], ...source } = {}) => create(StatsSchema, {
  epoch: 1n, performers: performer ? [{ ...well, ...performer }] : [],
  sources: [...sources, { name: 'stage', type: 'mvn', listen: 'udp://0.0.0.0:9763', received: BigInt(received), ...source }],
  counters: Object.entries({ 'publish.subscriptions': 4, ...counters }).map(([name, value]) => ({ name, value: BigInt(value) })),
});
const states = (links) => links.map(({ state }) => state).join(' ');
const chain = (now, before, performer = 'stage.anna', arrived = 120) => chainOf(now, before, performer, arrived);

test('all is well', () => {
  const links = chain(stats({}, { received: 1120 }), stats({}));
  assert.equal(links.map(({ name }) => name).join(), 'Rig,Port,Body,Neutral,Style,Reader');
  assert.equal(states(links), 'ok ok ok ok ok ok');
  assert.equal(links.map(({ text }) => text).join('; '), 'mvn, 120 frames a second; udp://0.0.0.0:9763; 23 joints, mvn; learned 100 %; ' +
    'elderly, moves a limb by 12 cm; this page gets 120 frames a second; 4 topics are read in all');
});

test('nobody: the port that hears nothing, the rig that stopped, the data that are no pose', () => {
  const never = chain(stats(undefined, { received: 0 }), undefined, '');
  assert.equal(states(never), 'off bad off off off off');
  assert.match(never[1].text, /^udp:\/\/0\.0\.0\.0:9763: nothing has ever arrived\..*firewall/);
  const stopped = chain(stats(undefined), stats(undefined), '');
  assert.equal(states(stopped), 'bad ok off off off off');
  assert.match(stopped[0].text, /Is the rig's application still sending\?/);
  const garbage = chain(stats(undefined, { received: 1120, counters: { 'source.bad_magic': 120 } }), stats(undefined), '');
  assert.equal(states(garbage), 'ok ok bad off off off');
  assert.match(garbage[2].text, /^Data arrive, but no pose: they are not what this type of source understands.*bad_magic/);
  const none = chainOf(create(StatsSchema, { epoch: 1n }), undefined, '', 0);
  assert.equal(states(none), 'off bad off off off off');
  assert.match(none[1].text, /No source is configured/);
});

test('a performer falls silent: the rig is the link, the others are as they were', () => {
  const links = chain(stats({ live: false }), stats({}), 'stage.anna', 0);
  assert.equal(states(links), 'bad ok off ok off off');
  assert.equal(links[2].text, '23 joints, mvn');
});

test('each fault of a live performer is at its link', () => {
  const of = (performer, options = {}, arrived = 120) => states(chain(stats(performer, { received: 1120, ...options }), stats({}), 'stage.anna', arrived));
  assert.equal(of({}, { kernelDropped: 7n }), 'ok warn ok ok ok ok');
  assert.equal(of({ warning: 'left and right are exchanged' }), 'ok ok warn ok ok ok');
  assert.equal(of({ neutral: { learned: 0.3 } }), 'ok ok ok warn ok ok');
  assert.equal(of({ neutral: { learned: 0.3, calibrated: true } }), 'ok ok ok ok ok ok');
  assert.equal(of({ neutral: { learned: 1, calibratesS: 3 } }), 'ok ok ok warn ok ok');
  assert.equal(of({ neutral: undefined }), 'ok ok ok off ok ok');
  assert.equal(of({ look: { strength: 1, mix: [] } }), 'ok ok ok ok off ok');
  assert.equal(of({ look: { strength: 0, mix: well.look.mix } }), 'ok ok ok ok warn ok');
  assert.equal(of({ hardlyStyled: true }), 'ok ok ok ok warn ok');
  assert.equal(of({ overloadBypass: true }), 'ok ok ok ok bad ok');
  assert.equal(of({}, {}, 0), 'ok ok ok ok ok bad');
  assert.equal(of({}, { counters: { 'publish.canary_missed': 3 } }), 'ok ok ok ok ok warn');
  assert.equal(of({}, { counters: { 'publish.subscribers_stalled': 1 } }), 'ok ok ok ok ok warn');
});

test('another source that sends is not blamed for, nor credited to, this performer', () => {
  const phone = (received) => [{ name: 'phone', type: 'livelinkface', received: BigInt(received), mergeInto: '*' }];
  const links = chain(stats({ live: false }, { sources: phone(500) }), stats({}, { sources: phone(440) }), 'stage.anna', 0);
  assert.equal(states(links).slice(0, 6), 'bad ok');
  const longer = [{ name: 'sta', type: 'vmc', received: 5n }];
  assert.match(chain(stats({}, { received: 1120, sources: longer }), stats({}, { sources: longer }))[0].text, /^mvn/);
});

test('a restarted daemon counts from 0: nothing is compared with before', () => {
  const now = stats({}, { received: 3, counters: { 'publish.canary_missed': 1 } });
  const before = stats({}, { received: 9000 });
  before.epoch = 0n;
  assert.equal(states(chain(now, before)), 'ok ok ok ok ok ok');
});
