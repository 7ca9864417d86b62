// The page in a real browser, in front of a fake daemon, which reports the rare cases: a look that another
// client changes at the same time, layers, props, a silent source.
//   STYLED_BIN=build/release/bin CHROMIUM=/usr/bin/chromium node --test fake.test.mjs
// SCREENSHOTS: a folder for screenshots. PATIENCE: factor of all waits.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { makeAvatar } from './avatar.mjs';
import { axeOf, bin, drawSeldom, drop, endAll, launch, patience, takePicture, until } from './house.mjs';

const { Daemon } = await import(`${bin}/../npm/js/test-support/daemon.mjs`);
const { StatsSchema } = await import(`${bin}/../npm/js/dist/index.js`);
const { fromBinary, toBinary } = await import(`${bin}/../npm/node_modules/@bufbuild/protobuf/dist/esm/index.js`);
let browser, page, daemon;
const errors = [], downloads = [];

before(async () => {
  daemon = await Daemon.start(['rig.anna', 'rig.ben'], `${bin}/../web`);
  daemon.list.cues = [['entrance', '01:00:00:00'], ['storm', ''], ['calm', '']].map(([name, at]) => ({ name, at, performer: '*' }));
  daemon.cues.set('entrance', { mix: [{ style: 'elderly', weight: 1 }] }).set('storm', { mix: [{ style: 'angry', weight: 1 }], strength: 1.5 });
  browser = await launch();
  page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.setDefaultTimeout(60000 * patience);
  page.on('download', (download) => downloads.push(download));
  page.on('pageerror', (error) => errors.push(error.message));
  // A connection that a busy machine is slow to make is given up, and made again.
  page.on('console', (message) => message.type() === 'error' && !/WebSocket is closed before/.test(message.text()) && errors.push(message.text()));
  await drawSeldom(page, 1000);
  await page.goto(daemon.gateway.url);
  await until(() => page.evaluate(() => globalThis.styled.app.live().length === 2 && globalThis.styled.app.list), 'two performers');
});

after(async () => {
  await endAll(browser);
  await daemon?.stop();
});

const toast = () => page.locator('.toast').innerText();
const offered = () => page.locator('[data-toast=undo]');
const said = (words) => until(async () => words.test(await toast()), words);
const looks = () => Object.fromEntries([...daemon.looks].map(([performer, { mix, strength, parts, inputStyle }]) =>
  [performer, { mix: mix.map(({ style, weight }) => `${style} ${weight}`).join(), strength, parts: parts.join(), inputStyle, pinned: daemon.pinned.has(performer) }]));
const click = (what) => page.locator(what).click();

test('after Panic the message offers Undo: each look comes back, also of who is pinned, and nothing else', async () => {
  daemon.set('rig.anna', { mix: [{ style: 'elderly', weight: 0.75 }, { style: 'angry', weight: 0.25 }], strength: 0.5, parts: [1, 3], inputStyle: 'active' });
  daemon.set('rig.ben', { mix: [{ style: 'youthful', weight: 1 }], strength: 1.25 });
  daemon.pinned.add('rig.ben');
  daemon.tell();
  const before = looks();
  await until(() => page.evaluate(() => globalThis.styled.app.performers().some(({ pinned }) => pinned)), 'the looks');
  await page.keyboard.press('Escape');
  await until(() => [...daemon.looks.values()].every(({ mix }) => mix.length === 0), 'panic');
  await until(() => offered().isVisible(), 'the offer');
  await takePicture(page, 'undo');
  await offered().click();
  await said(/^undone: panic/);
  assert.deepEqual(looks(), before);
  assert.ok(!(await offered().isVisible()), 'it is done once');
  daemon.pinned.clear();
});

test('Ctrl+Z takes a style back; the offer ends after ten seconds', async () => {
  const before = looks();
  await click('[data-style=angry]');
  await until(() => looks()['rig.anna'].mix === 'angry 1', 'the style');
  await until(() => offered().isVisible(), 'the offer');
  const begun = Date.now();
  await page.keyboard.press('Control+z');
  await until(() => looks()['rig.anna'].mix === before['rig.anna'].mix, 'the look before');
  assert.deepEqual(looks(), before);
  await click('[data-style=youthful]');
  await until(() => offered().isVisible(), 'the offer again');
  await until(async () => !(await offered().isVisible()), 'its end', 30);
  assert.ok(Date.now() - begun > 9000, 'it is there long enough');
  await page.keyboard.press('Control+z');
  await until(() => looks()['rig.anna'].mix === before['rig.anna'].mix, 'the look before, still');
});

test('who was changed by someone else meanwhile is left so, and that is said; others come back', async () => {
  const before = looks();
  await page.keyboard.press('Escape');
  await until(() => offered().isVisible(), 'the offer');
  daemon.set('rig.ben', { mix: [{ style: 'active', weight: 1 }] });
  await offered().click();
  await said(/^undo of panic: rig\.ben was changed by another user since, and not undone/);
  assert.deepEqual(looks()['rig.anna'], before['rig.anna']);
  assert.equal(looks()['rig.ben'].mix, 'active 1');
});

test('a change of someone else just before ours is part of what comes back', async () => {
  daemon.set('rig.anna', { mix: [{ style: 'youthful', weight: 0.5 }] }); // no statistics report it
  await click('[data-style=angry]');
  await until(() => offered().isVisible(), 'the offer');
  await page.keyboard.press('Control+z');
  await until(() => looks()['rig.anna'].mix === 'youthful 0.5', 'what the other has set');
});

test('a slider that is dragged is one step, and may be changed again by us', async () => {
  const knob = page.locator('input[name=strength]');
  const { strength } = looks()['rig.anna'];
  for (const value of ['0.9', '1.1', '1.3']) await knob.fill(value);
  await until(() => looks()['rig.anna'].strength === Math.fround(1.3), 'the strength');
  await page.waitForTimeout(600); // the page has learned its result
  await page.keyboard.press('Control+z');
  await until(() => looks()['rig.anna'].strength === strength, 'the strength before');
});

test('strength 0 is said beside the styles, and one click sets it to 1', async () => {
  const words = page.locator('.unseen');
  daemon.set('rig.anna', { clear: true, strength: 0 });
  daemon.tell();
  await until(() => page.evaluate(() => globalThis.styled.app.entry().look.strength === 0), 'the strength');
  assert.ok(!(await words.isVisible()), 'no style is set');
  await click('[data-style=angry]');
  await until(() => words.isVisible(), 'the words');
  assert.match(await words.innerText(), /^Strength is 0: no style is visible\./);
  assert.equal(looks()['rig.anna'].strength, 0, 'it is not changed behind the back of the user');
  for (const [width, height] of [[1280, 720], [390, 844]]) {
    await page.setViewportSize({ width, height });
    assert.deepEqual(await (await axeOf(page))('.stylebox'), [], `${width} x ${height}`);
    await words.scrollIntoViewIfNeeded();
    await takePicture(page, `strength 0 ${width}x${height}`);
  }
  const { width, height } = await page.locator('[data-strength]').boundingBox();
  assert.ok(width >= 44 && height >= 44, `${width} x ${height}`);
  await page.setViewportSize({ width: 1280, height: 720 });
  await click('[data-strength]');
  await until(async () => looks()['rig.anna'].strength === 1 && !(await words.isVisible()), 'the style to be seen');
  assert.equal(looks()['rig.anna'].mix, 'angry 1');
});

test('cues: GO, the next, Back, by key and by name; the one in force is marked', async () => {
  const current = () => page.locator('.cues [aria-current=step]').evaluateAll((rows) => rows.map((row) => row.dataset.cue).join());
  assert.equal(await page.locator('[data-cue-back]').isDisabled(), true);
  await click('[data-cue-go]');
  await until(async () => (await current()) === 'entrance', 'the first cue');
  assert.equal(looks()['rig.anna'].mix, 'elderly 1');
  await page.keyboard.press('g');
  await until(async () => (await current()) === 'storm', 'the second');
  assert.deepEqual([looks()['rig.ben'].mix, looks()['rig.ben'].strength], ['angry 1', 1.5]);
  await takePicture(page, 'cues');
  await click('[data-cue-back]');
  await until(async () => (await current()) === 'entrance', 'the first again');
  await click('[data-cue=calm]'); // the daemon does not have it any more
  await said(/no cue "calm"/);
  assert.equal(await current(), 'entrance');
  await page.keyboard.press('Control+z');
  await until(() => looks()['rig.ben'].mix === 'angry 1', 'the look before the cue');
  daemon.list.cues = [];
  await page.evaluate(() => globalThis.styled.app.fetchList());
  await until(async () => !(await page.locator('.cues').isVisible()), 'no cues, no panel');
});

test('the own style is of the selected performer alone, and is seen', async () => {
  daemon.list.cues = [{ name: 'entrance', at: '', performer: '*' }];
  await click('[data-performer="rig.ben"]');
  await click('[data-who=true]'); // everyone, which does not count here
  await page.locator('select[name=own]').selectOption('youthful');
  await until(() => looks()['rig.ben'].inputStyle === 'youthful', 'the own style');
  assert.equal(looks()['rig.anna'].inputStyle, 'active');
  await until(async () => /moves as: youthful/.test(await page.locator('[data-performer="rig.ben"]').innerText()), 'the row');
  await page.locator('select[name=own]').selectOption('');
  await until(() => looks()['rig.ben'].inputStyle === '', 'none');
  await click('[data-who=false]');
  await click('[data-performer="rig.anna"]');
});

test('what other sources give a performer is in the row, and which of them is silent', async () => {
  daemon.layers.set('rig.anna', [{ source: 'phone', part: 'face', live: true }, { source: 'gloves', part: 'fingers', live: false }]);
  daemon.tell();
  const parts = page.locator('[data-performer="rig.anna"] .layers span');
  await until(async () => (await parts.count()) === 3, 'the layers');
  assert.deepEqual(await parts.allInnerTexts(), ['moves as: active', 'face: phone', 'fingers: gloves, silent']);
  assert.deepEqual(await parts.evaluateAll((all) => all.map(({ className }) => className)), ['live', 'live', 'silent']);
  const row = await page.locator('[data-performer="rig.anna"]').boundingBox(), line = await parts.last().boundingBox();
  assert.ok(line.x > row.x && line.x + line.width < row.x + row.width && line.y + line.height < row.y + row.height, 'they are within the row');
});

test('what is wrong with a performer is in the row: the warning, and that they are hardly styled', async () => {
  const { gateway } = daemon, publish = gateway.publish.bind(gateway);
  let more = {};
  gateway.publish = (topic, bytes) => {
    if (topic !== 'stats/') return publish(topic, bytes);
    const stats = fromBinary(StatsSchema, bytes);
    Object.assign(stats.performers.find(({ performer }) => performer === 'rig.anna'), more);
    return publish(topic, toBinary(StatsSchema, stats));
  };
  daemon.set('rig.anna', { mix: [{ style: 'angry', weight: 1 }], strength: 1, parts: [0] });
  const row = page.locator('[data-performer="rig.anna"]'), words = row.locator('.wrong');
  const reads = (text) => until(async () => (await words.isVisible()) && (await words.innerText()) === text, text);
  const warning = 'style "pirate" is gone: its file /srv/styles/pirate.json was removed';
  more = { warning };
  await reads(warning);
  more = { hardlyStyled: true };
  await reads('hardly styled now');
  more = { warning, hardlyStyled: true };
  await reads(`${warning}; hardly styled now`);
  const [box, line] = [await row.boundingBox(), await words.boundingBox()];
  assert.ok(line.x > box.x && line.x + line.width < box.x + box.width && line.y + line.height < box.y + box.height, 'it is within the row');
  assert.ok(await words.evaluate((line) => line.scrollWidth <= line.clientWidth), 'and whole');
  assert.deepEqual(await (await axeOf(page))('.roster'), []);
  await takePicture(page, 'wrong');
  more = { hardlyStyled: false };
  await until(async () => !(await words.isVisible()), 'nothing to be wrong');
  gateway.publish = publish;
  daemon.set('rig.anna', { clear: true, parts: [0] });
});

const SLIDERS = [['stoop', 'Stoop', 'Posture', 'degrees', -30, 60, 0], ['chin', 'Chin', 'Posture', 'degrees', -40, 40, 0],
  ['energy', 'Energy', 'Character', '', 0, 2, 1], ['hold', 'Hold and snap', 'Character', 's', 0, 1, 0]]
  .map(([name, title, group, unit, least, most, usual]) => ({ name, title, group, unit, least, most, usual, what: `What ${name} does.` }));
const knob = (name) => page.locator(`[data-slider=${name}] input`);
const value = (name) => page.locator(`[data-slider=${name}] output`).innerText();
const lastLike = () => daemon.likes.at(-1);

test('without sliders there is no style by hand; with them they are there by group, with value and unit', async () => {
  assert.ok(!(await page.locator('.byhand').isVisible()));
  Object.assign(daemon.list, { sliders: SLIDERS, designs: [{ name: 'sneaky', sliders: { stoop: 28, energy: 0.6 } }] });
  await page.evaluate(() => {
    globalThis.styled.cards.previews.forgive(); // this daemon has some, now
    return globalThis.styled.app.fetchList();
  });
  await page.locator('.byhand summary').click();
  await until(() => knob('stoop').isVisible(), 'the sliders');
  assert.deepEqual(await page.locator('.byhand legend').allInnerTexts(), ['Posture', 'Character']);
  assert.deepEqual([await value('stoop'), await value('energy'), await value('hold')], ['0°', '× 1', '0 s']);
  assert.deepEqual([await knob('stoop').getAttribute('aria-valuetext'), await knob('stoop').getAttribute('title')], ['0 degrees', 'What stoop does.']);
  assert.equal(daemon.likes.length, 0, 'nothing is sent');
  for (const [width, height] of [[1280, 720], [390, 844]]) {
    await page.setViewportSize({ width, height });
    assert.deepEqual(await (await axeOf(page))('.byhand'), [], `${width} x ${height}`);
    await page.locator('.byhand').scrollIntoViewIfNeeded();
    await takePicture(page, `by hand ${width}x${height}`);
  }
  await page.setViewportSize({ width: 1280, height: 720 });
});

test('a slider moves the style live: one request at a time, then the newest values', async () => {
  daemon.set('rig.anna', { mix: [{ style: 'angry', weight: 1 }], strength: 1 });
  daemon.tell();
  await until(() => page.evaluate(() => globalThis.styled.app.entry().look.mix[0]?.style === 'angry'), 'the look');
  let answer;
  daemon.hold = new Promise((resolve) => (answer = resolve));
  for (const stoop of ['3', '9', '20']) await knob('stoop').fill(stoop);
  await knob('energy').fill('0.5');
  await page.waitForTimeout(300);
  assert.equal(daemon.likes.length, 1, 'the first is not answered yet');
  assert.deepEqual([lastLike().performer, lastLike().name, lastLike().design.from, lastLike().design.sliders],
    ['rig.anna', '', 'neutral', { stoop: 3, chin: 0, energy: 1, hold: 0 }]);
  daemon.hold = undefined;
  answer();
  await until(() => daemon.likes.length === 2, 'the second');
  assert.deepEqual(lastLike().design.sliders, { stoop: 20, chin: 0, energy: 0.5, hold: 0 });
  await until(() => looks()['rig.anna'].mix === 'by-hand-rig-anna 1', 'the style to be worn');
  assert.deepEqual([await value('stoop'), await value('energy')], ['20°', '× 0.5']);
  await until(() => daemon.previews.includes('by-hand-rig-anna'), 'its figure');
  await until(() => page.locator('.design canvas').evaluate((canvas) => new Uint32Array(canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.buffer).some((pixel) => pixel !== 0)), 'a drawn figure');
  await takePicture(page, 'by hand figure');
  const before = daemon.previews.length;
  await knob('stoop').press('ArrowRight');
  await until(() => lastLike().design.sliders.stoop === 21, 'the arrow key');
  await until(() => daemon.previews.slice(before).includes('by-hand-rig-anna'), 'its figure again, once the slider rests');
});

test('undo, redo and reset of sliders', async () => {
  await until(async () => page.evaluate(() => globalThis.styled.app.entry().look.mix[0]?.style === 'by-hand-rig-anna'), 'the look');
  await page.waitForTimeout(1600); // another gesture
  await knob('chin').fill('10');
  await until(() => lastLike().design.sliders.chin === 10, 'the chin');
  await click('[data-design=undo]');
  await until(async () => lastLike().design.sliders.chin === 0 && (await value('chin')) === '0°', 'the chin before');
  await page.keyboard.press('Control+Shift+Z');
  await until(async () => lastLike().design.sliders.chin === 10 && (await value('chin')) === '10°', 'the chin again');
  assert.equal(await page.locator('[data-design=redo]').isDisabled(), true);
  await click('[data-design=reset]');
  await until(() => lastLike().design.sliders.stoop === 0, 'the start');
  assert.deepEqual(lastLike().design.sliders, { stoop: 0, chin: 0, energy: 1, hold: 0 });
  await page.keyboard.press('Control+z');
  await until(() => lastLike().design.sliders.chin === 10, 'what was before the reset');
});

test('a style begins with a design, is saved under a name with all its sliders, and shared', async () => {
  const from = page.locator('select[name=design_from]');
  await from.selectOption('design sneaky');
  await until(async () => lastLike().design.sliders.stoop === 28 && (await value('energy')) === '× 0.6', 'the design');
  await page.locator('input[name=design_name]').fill('angry');
  await click('[data-design=save]');
  assert.match(await page.locator('.saving .hint').innerText(), /angry is already a name/);
  await page.locator('input[name=design_name]').fill('thief');
  await click('[data-design=save]');
  await said(/^thief is saved/);
  const { performer, name, design } = lastLike();
  assert.deepEqual([performer, name, design.from, Object.keys(design.sliders).length, design.sliders.stoop], ['', 'thief', 'neutral', 4, 28]);
  assert.equal(looks()['rig.anna'].mix, 'by-hand-rig-anna 1', 'the performer goes on');
  await until(() => page.locator('[data-style=thief]').count(), 'its card');
  await click('[data-design=share]');
  await until(() => downloads.length === 1, 'its file');
  assert.equal(downloads.splice(0)[0].suggestedFilename(), 'thief.json');
  await from.selectOption('style thief');
  await until(() => lastLike().design.from === 'thief', 'the made style');
});

test('an error of the daemon is said, and sliders that others have moved are followed', async () => {
  daemon.pinned.add('rig.anna');
  await knob('hold').fill('0.3');
  await said(/like: rig\.anna is pinned/);
  daemon.pinned.clear();
  await page.waitForTimeout(1600);
  daemon.list.styles.find(({ name }) => name === 'by-hand-rig-anna').sliders = { stoop: 44 };
  await page.evaluate(() => globalThis.styled.app.fetchList());
  await until(async () => (await value('stoop')) === '44°', "the other's stoop");
  assert.equal(await value('hold'), '0 s');
  await click('[data-performer="rig.ben"]');
  await until(async () => (await value('stoop')) === '0°', 'the sliders of the other performer');
  await click('[data-performer="rig.anna"]');
  await page.locator('.byhand summary').click();
});

test('what was found of an example is listed, and it can be added to the made style that is chosen', async () => {
  daemon.found = { found: ['walk: 7.2 strides in 6.4 s', 'run: 3 strides'], weak: ['walk: only 2.1 s; show 3 s or more'] };
  daemon.tell();
  await drop(page, ['pirate.bvh', Buffer.from('HIERARCHY')]);
  await page.locator('.ask').waitFor();
  await until(async () => /add to by-hand-rig-anna/.test(await page.locator('.ask').innerText()), 'the offer');
  await page.locator('input[name=style]').fill('thief'); // made, too
  await page.getByLabel('add to thief').check();
  assert.doesNotMatch(await page.locator('.ask').innerText(), /Replaces/);
  await click('.ask .go');
  await until(() => page.locator('.result .found li').count(), 'the findings');
  assert.deepEqual([lastLike().name, lastLike().add, lastLike().file], ['thief', true, 'pirate.bvh']);
  assert.match(await page.locator('.result').innerText(), /^pirate\.bvh is added to thief/);
  assert.deepEqual(await page.locator('.result .found li').allInnerTexts(), daemon.found.found);
  assert.deepEqual(await page.locator('.result .weak li').allInnerTexts(), daemon.found.weak);
  const ordinary = page.locator('[data-ordinary]'), { gateway } = daemon, publish = gateway.publish.bind(gateway);
  assert.ok(!(await ordinary.isVisible()));
  gateway.publish = (topic, bytes) => {
    if (topic !== 'stats/') return publish(topic, bytes);
    const stats = fromBinary(StatsSchema, bytes);
    for (const entry of stats.performers) entry.hardlyStyled = true;
    return publish(topic, toBinary(StatsSchema, stats));
  };
  await until(() => ordinary.isVisible(), 'the sentence that the example is ordinary motion');
  gateway.publish = publish;
  await until(async () => !(await ordinary.isVisible()), 'it to go');
  assert.doesNotMatch(await page.locator('.result').innerText(), /weak mixture/, 'what is measured is good however far it is');
  assert.deepEqual(await (await axeOf(page))('.examples'), []);
  Object.assign(daemon.list, { sliders: [], designs: [], styles: daemon.list.styles.filter(({ made }) => !made) });
  daemon.set('rig.anna', { clear: true });
  await page.evaluate(() => globalThis.styled.app.fetchList());
  await until(async () => !(await page.locator('.byhand').isVisible()), 'no sliders, no panel');
});

const placeOf = (prop) => page.evaluate((prop) => [...globalThis.styled.stage.performers.values()].find(({ name }) => name === 'rig.anna').roles.after.props.place(prop), prop);

test('props stand on the stage, and go', async () => {
  daemon.fields = (i) => ({ props: [{ name: 'sword', position: [0.5, 1.2, 0.9 * (i / 20) + 0.2], rotation: [0, 0, 0.38, 0.92] }, { name: 'Stuhl №2', position: [-0.6, 0.45, 0.9 * (i / 20)], rotation: [0, 0, 0, 1] }] });
  await until(async () => (await placeOf('sword'))?.[1] > 1.19, 'the sword');
  const sizes = [[1280, 720], [1920, 1080], [390, 844]];
  for (const [width, height] of sizes) {
    await page.setViewportSize({ width, height });
    await page.waitForTimeout(1500);
    await takePicture(page, `fake ${width}x${height}`);
    assert.deepEqual(await (await axeOf(page))(), [], `${width} x ${height}`);
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  daemon.fields = (i) => ({ props: [{ name: 'Stuhl №2', position: [-0.6, 0.45, 0.9 * (i / 20)], rotation: [0, 0, 0, 1] }] });
  await until(async () => (await placeOf('sword')) === undefined, 'the sword to go');
});

// The description in a file of glTF.
const description = (bytes) => JSON.parse(bytes.subarray(20, 20 + bytes.readUInt32LE(12)).toString());

test('a take is saved as VRMA, and as glTF of the avatar that is worn', async () => {
  daemon.fields = () => ({ expressions: [{ name: 'Joy', value: 0.5 }, { name: 'jawOpen', value: 0.25 }] });
  const list = page.getByLabel('Formats to save');
  assert.equal(await list.locator('option[value=avatar]').isDisabled(), true, 'nobody wears an avatar');
  await drop(page, ['boxes.vrm', makeAvatar(undefined, { details: true })]);
  await until(() => page.evaluate(() => globalThis.styled.stage.performers.get('rig.anna').avatar?.ready), 'the avatar');
  await list.selectOption('vrma');
  await click('button.record');
  await until(() => page.evaluate(() => globalThis.styled.recorder.frames > 30), 'frames');
  await click('button.record');
  await until(() => downloads.length === 1, 'the animation');
  await click('[data-save=avatar]');
  await until(() => downloads.length === 2, 'the avatar');
  await takePicture(page, 'saved');
  const [vrma, avatar] = await Promise.all(downloads.splice(0).map(async (download) => [download.suggestedFilename(), description(readFileSync(await download.path()))]));
  assert.match(vrma[0], /^rig\.anna-vrma-[\d-]+(filled)?\.vrma$/);
  const { humanoid, expressions, lookAt } = vrma[1].extensions.VRMC_vrm_animation;
  assert.equal(Object.keys(humanoid.humanBones).length, 21);
  assert.deepEqual([Object.keys(expressions.preset), Object.keys(expressions.custom)], [['happy'], ['jawOpen']]);
  assert.ok(lookAt);
  assert.match(avatar[0], /^rig\.anna-avatar-[\d-]+(filled)?\.glb$/);
  assert.ok(avatar[1].extensions.VRMC_vrm);
  assert.equal(avatar[1].animations[0].name, 'rig.anna');
  const { count, max } = avatar[1].accessors[avatar[1].animations[0].samplers[0].input];
  assert.ok(count > 20 && Math.abs(max[0] - (count - 1) / 20) < 0.01, `${count} frames, ${max[0]} s`);
});

// The styles of the shipped weights, as their cards are: those of v2 that are weak, and what an example can be called.
const SHIPPED = 'active angry childish* elderly exhausted feminine giant happy* masculine musical* not-confident proud* sad* swagger youthful elated graceful limping rushed*'.split(' ');
const LONG = 'the-pirate-of-the-second-act', FAIR = 'my-pirate-of-monday';

test('the names of styles are seen whole, whatever the window, with and without figures', async () => {
  const { styles } = daemon.list;
  daemon.list.styles = [{ name: 'neutral', neutral: true },
    ...SHIPPED.map((name) => ({ name: name.replace('*', ''), weak: name.endsWith('*'), recognized: 0.4 })),
    ...[LONG, FAIR].map((name) => ({ name, made: true, source: 'walk.bvh' }))];
  await page.evaluate(() => globalThis.styled.app.fetchList());
  assert.match(await page.locator(`[data-style="${LONG}"]`).getAttribute('title'), new RegExp(`^${LONG}`));
  for (const [width, height] of [[1280, 720], [1920, 1080], [390, 844]]) {
    await page.setViewportSize({ width, height });
    for (const plain of [true, false]) {
      const wrong = await page.evaluate((plain) => {
        document.querySelector('.styles').classList.toggle('plain', plain);
        const within = (a, b) => a.left >= b.left - 0.5 && a.right <= b.right + 0.5 && a.top >= b.top - 0.5 && a.bottom <= b.bottom + 0.5;
        const apart = (a, b) => a.right <= b.left + 0.5 || b.right <= a.left + 0.5 || a.bottom <= b.top + 0.5 || b.bottom <= a.top + 0.5;
        const cards = [...document.querySelectorAll('.card')];
        for (const card of cards) card.style.contentVisibility = 'visible'; // also those that are scrolled out
        return cards.flatMap((card) => {
          const name = card.querySelector('.name'), text = document.createRange();
          text.selectNodeContents(name);
          const words = text.getBoundingClientRect(), faults = [];
          if (!within(words, card.getBoundingClientRect())) faults.push('cut off');
          for (const other of card.querySelectorAll('small, kbd, .more')) {
            const box = other.getBoundingClientRect();
            if (box.width > 0 && !apart(words, box)) faults.push(`under ${other.textContent}`);
          }
          if (name.scrollWidth > name.clientWidth) faults.push('with an ellipsis');
          return faults.map((fault) => `${name.textContent} ${fault}`);
        });
      }, plain);
      await page.waitForTimeout(300);
      await takePicture(page, `names ${plain ? 'plain ' : ''}${width}x${height}`);
      const long = wrong.filter((text) => text.startsWith(LONG));
      assert.deepEqual(wrong.filter((text) => !long.includes(text)), [], `${width} x ${height}, ${plain ? 'plain' : 'figures'}`);
      assert.equal(await page.locator(`[data-style="${LONG}"] .name`).evaluate((name) => getComputedStyle(name).textOverflow), 'ellipsis');
    }
  }
  await page.setViewportSize({ width: 1280, height: 720 });
  daemon.list.styles = styles;
  await page.evaluate(() => {
    document.querySelector('.styles').classList.add('plain');
    for (const card of document.querySelectorAll('.card')) card.style.contentVisibility = '';
    return globalThis.styled.app.fetchList();
  });
});

test('a video has the props that were there when it was taken', async () => {
  daemon.fields = () => ({ props: [{ name: 'sword', position: [0.5, 1.25, 0.75], rotation: [0, 0, 0, 1] }] });
  await until(async () => (await placeOf('sword')) !== undefined, 'the sword');
  await page.getByLabel('Formats to save').selectOption('video');
  await click('button.record');
  await until(() => page.evaluate(() => globalThis.styled.recorder.frames > 15), 'frames');
  await click('button.record');
  daemon.fields = () => ({});
  await page.evaluate(() => {
    globalThis.filmed = [];
    const { stage } = globalThis.styled, { roles } = stage.performers.get('rig.anna');
    globalThis.looking = setInterval(() => document.querySelector('.filming') && globalThis.filmed.push(
      [roles.before, roles.after].map(({ props }) => props.group.visible && props.place('sword'))), 20);
  });
  await until(() => downloads.length === 1, 'the video', 60);
  const filmed = await page.evaluate(() => (clearInterval(globalThis.looking), globalThis.filmed));
  assert.match(downloads.splice(0)[0].suggestedFilename(), /^rig\.anna-video-/);
  assert.ok(filmed.length > 2, 'it was looked at');
  // The first look may come before the first picture.
  for (const places of filmed.slice(1)) assert.deepEqual(places, [[0.5, 1.25, 0.75], [0.5, 1.25, 0.75]]);
  await page.getByLabel('Formats to save').selectOption('styled');
});

test('plots are grey and say that no data come, while the daemon is away or says nothing', async () => {
  const figures = async () => (await page.locator('.plot output').allInnerTexts()).join();
  const away = (up) => daemon.gateway.notice({ styleweb: 'fake', watchOnly: false, daemon: { up, reason: '' } });
  const none = 'no data,no data,no data', { tell } = Object.getPrototypeOf(daemon);
  await until(async () => (await figures()).includes('20.0 Hz'), 'figures');
  daemon.tell = () => {};
  away(false);
  await until(async () => (await figures()) === none, 'no figures', 2);
  assert.equal(await page.locator('.plot.nodata').count(), 3);
  assert.deepEqual(await (await axeOf(page))('.plots'), []);
  await takePicture(page, 'no data');
  away(true);
  daemon.tell = tell;
  await until(async () => (await figures()).includes('20.0 Hz') && (await page.locator('.plot.nodata').count()) === 0, 'figures again');
  daemon.tell = () => {}; // it is there, and hangs
  await until(async () => (await figures()) === none, 'no figures');
  daemon.tell = tell;
  await until(async () => (await figures()).includes('20.0 Hz'), 'figures again');
});

test('OBS sees props only where its link asks for them', async () => {
  daemon.fields = (i) => ({ props: [{ name: 'sword', position: [0.5, 1.2, 0.9 * (i / 20)], rotation: [0, 0, 0, 1] }] });
  const shown = () => page.evaluate(() => [...globalThis.styled.stage.performers.values()][0]?.roles.after.props.group.visible);
  for (const [query, wanted] of [['', false], ['&props=1', true], ['&props=0', false]]) {
    await page.goto(`${daemon.gateway.url}/?view=avatar&performer=rig.anna&bg=00ff00${query}`);
    await until(async () => (await placeOf('sword')) !== undefined && (await shown()) === wanted, `props: ${query || 'none'}`);
    await page.waitForTimeout(3000);
    await takePicture(page, `obs${query.replace(/\W/g, '')}`);
  }
});

test('OBS is told what its link asks for in vain, until the first frame and never afterwards', async () => {
  const note = page.locator('.note');
  const view = (query) => page.goto(`${daemon.gateway.url}/?view=avatar&${query}`);
  const reads = (words) => until(async () => (await note.isVisible()) && words.test(await note.innerText()), words, 20);
  await page.mouse.move(0, 0);
  await view('performer=rig.ann&bg=00ff00');
  await reads(/^no performer rig\.ann here; here are: rig\.anna, rig\.ben$/);
  await takePicture(page, 'obs mistyped');
  assert.deepEqual(await (await axeOf(page))(), []);
  daemon.live = false;
  await reads(/^no performer rig\.ann here; nobody is$/);
  await view('performer=rig.anna');
  await reads(/^rig\.anna is silent\.$/);
  daemon.live = true;
  await until(async () => !(await note.isVisible()), 'the words to go');
  daemon.live = false;
  daemon.tell();
  await page.waitForTimeout(4000);
  assert.ok(!(await note.isVisible()), 'a show is not disturbed');
  daemon.live = true;
  await view('performer=rig.anna&avatar=Missing.vrm');
  await reads(/^avatar Missing\.vrm is not on this browser: click to choose it, or drop it here$/);
  await takePicture(page, 'obs without its avatar');
  await until(async () => !(await note.isVisible()), 'the words to go', 30);
  await page.waitForTimeout(2000);
  assert.ok(!(await note.isVisible()), 'they do not come again');
  await view('performer=rig.anna');
  let said = false;
  for (let i = 0; i < 30; ++i, await page.waitForTimeout(100)) said ||= await note.isVisible();
  assert.ok(!said, 'nothing is amiss');
});

test('a rig that is silent: what its phone and a source that asks a server lack', async () => {
  daemon.live = false;
  daemon.fields = () => ({});
  daemon.sources = [{ name: 'stage', type: 'natnet', listen: 'udp://0.0.0.0:1511', received: 0n },
    { name: 'phone', type: 'ifacialmocap', listen: 'udp://0.0.0.0:49983', received: 0n }];
  await page.goto(daemon.gateway.url);
  const lines = page.locator('.banner li');
  await until(async () => (await lines.count()) === 2, 'the findings');
  const [stage, phone] = await lines.allInnerTexts();
  assert.match(stage, /^stage \(natnet, .*asks Motive, which has never answered/);
  assert.match(phone, /^phone \(ifacialmocap, .*asks the phone, which has never answered/);
  await takePicture(page, 'silent');
});

test('nothing went wrong within', () => assert.deepEqual(errors, []));
