// Styles by example on the page: clips that are dropped, takes, variations, the library, undo. Real
// browser, gateway, daemon and simulator; the weights are random ones with a style encoder.
//   STYLED_BIN=build/release/bin CAUSAL_WEIGHTS=FILE CHROMIUM=/usr/bin/chromium node --test examples.test.mjs
// SCREENSHOTS: a folder for screenshots.
import assert from 'node:assert/strict';
import { mkdirSync, readFileSync, readdirSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { drawSeldom, drop, endAll, file, launch, patience, pause, start, startAll, startWeb, takePicture, until } from './house.mjs';

let browser, page, udp, sim, clip;
const errors = [], downloads = [];

async function open(address, options = {}) {
  const opened = await browser.newPage({ viewport: { width: 1280, height: 720 }, ...options });
  opened.setDefaultTimeout(60000 * patience);
  opened.on('download', (download) => downloads.push(download));
  opened.on('pageerror', (error) => errors.push(error.message));
  opened.on('console', (message) => {
    if (message.type() === 'error' && !/Failed to load/.test(message.text())) errors.push(message.text());
  });
  await drawSeldom(opened); // the stage is not what is tested here, unless a test wants otherwise
  await opened.goto(address);
  await until(() => opened.evaluate(() => globalThis.styled.app.list !== undefined), 'the styles');
  return opened;
}

before(async () => {
  mkdirSync(file('library'));
  ({ udp } = await startAll(`[model]
weights = "${process.env.CAUSAL_WEIGHTS}"
[style]
library = "${file('library')}"
`));
  const walk = start('stylesim', '--write', file('walk.bvh'), '--seconds', '3', '--rate', '30', '--script', 'walk:5');
  assert.equal(await walk.ended, 0);
  clip = readFileSync(file('walk.bvh'));
  const { address } = await startWeb('127.0.0.1:0');
  browser = await launch();
  page = await open(address);
});

after(() => endAll(browser));

const picture = (name) => takePicture(page, name);
const result = () => page.locator('.result').innerText();
const toast = () => page.locator('.toast').innerText();
const card = (name) => page.locator(`[data-style="${name}"]`);
const styles = () => page.evaluate(async () => (await globalThis.styled.client.list()).styles.map(({ name }) => name));
const look = () =>
  page.evaluate(async () => {
    const { stats } = await globalThis.styled.client.status();
    const { look } = stats.performers.find(({ performer }) => performer === globalThis.styled.app.selected);
    return { ...look, mix: look.mix.map(({ style }) => style) };
  });
const wears = (...names) => until(async () => (await look()).mix.join() === names.join(), `${names.join()} to be worn`);
const said = (words, read = result) => until(async () => words.test(await read()), String(words), 20);
const own = async () => (await page.locator('[data-style]').first().getAttribute('data-style'));
const form = () => page.locator('form.ask');

// Drops the clip, gives it this name, and waits for the style.
async function like(name, bytes = clip) {
  await drop(page, [`${name}.bvh`, bytes]);
  await form().locator('input[name=style]').fill(name);
  await form().locator('button[type=submit]').click();
  await said(new RegExp(`^${name} is made from ${name}\\.bvh`));
}

test('nobody is there: no take can be made, a clip can', async () => {
  const learn = page.locator('[data-example=learn]');
  assert.ok(await learn.isDisabled());
  assert.match(await learn.getAttribute('title'), /No performer is present/);
  await like('early');
  assert.match(await result(), /No performer wears it yet\./);
  await card('early').waitFor();
  await page.keyboard.press('l');
  assert.ok(!(await form().isVisible()));
  sim = start('stylesim', '--to', `udp://${udp}`, '--rate', '60', '--script', 'walk:5,turn-left:1');
  await until(() => learn.isEnabled(), 'a performer');
});

test('wrong files are told apart', async () => {
  const png = Buffer.from('iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNkYPhfDwAChwGA60e6kgAAAABJRU5ErkJggg==', 'base64');
  await drop(page, ['picture.bvh', png]);
  await form().locator('button[type=submit]').click();
  await said(/picture\.bvh.*expected/);
  assert.ok(await page.locator('.result.bad').isVisible());
  await drop(page, ['torn.bvh', clip.subarray(0, clip.length / 2)]);
  await form().locator('button[type=submit]').click();
  await said(/torn\.bvh(?!: reading)/);
  await drop(page, ['empty.bvh', Buffer.alloc(0)]);
  await said(/^empty\.bvh is empty\.$/);
  await drop(page, ['huge.bvh', Buffer.alloc(9 << 20)]);
  await said(/^huge\.bvh has 9\.0 MiB, expected at most 8\.0 MiB\.$/);
  await drop(page, ['notes.txt', Buffer.from('walk')]);
  await said(/^notes\.txt: expected \.vrm, an avatar; \.bvh, \.glb or \.vrma/, toast);
  await drop(page, ['style.json', Buffer.from('{}')]);
  await said(/style\.json|style file|expected/);
  assert.deepEqual((await styles()).filter((name) => /picture|torn|empty|huge/.test(name)), []);
});

test('a clip is dropped, named, and worn; Ctrl+Z leads back', async () => {
  await card(await own()).click();
  await wears(await own());
  await drop(page, ['Old Man.bvh', clip]);
  const name = form().locator('input[name=style]');
  assert.equal(await name.inputValue(), 'Old-Man');
  await name.fill('');
  await page.keyboard.type('two words 1');
  await name.press('Enter');
  assert.match(await form().innerText(), /only letters/);
  assert.deepEqual((await look()).mix, [await own()], 'digits and letters belong to the field');
  await picture('form');
  await name.fill(await own());
  assert.match(await form().innerText(), /is already a name of the weights/);
  await name.press('Escape');
  assert.ok(!(await form().isVisible()));
  assert.deepEqual((await look()).mix, [await own()], 'no panic: it closed the form');
  await drop(page, ['Old Man.bvh', clip]);
  await name.press('Enter');
  await said(/^Old-Man is made from Old Man\.bvh \(3\.0 s\)\. Nearest: \S+, distance \d+\.\d\d\./);
  await wears('Old-Man');
  await card('Old-Man').waitFor();
  // Its figure moves beside the neutral one's, and no panel of the left side leaves the screen.
  const beside = page.locator('.beside');
  assert.equal(await beside.innerText(), await page.evaluate(() => `${globalThis.styled.app.list.styles.find(({ neutral }) => neutral).name}\nOld-Man`));
  const inks = () => beside.locator('canvas').evaluateAll((all) => all.map((canvas) => canvas.getContext('2d')
    .getImageData(0, 0, canvas.width, canvas.height).data.filter((value, i) => i % 4 === 3 && value > 0).length));
  await until(async () => (await inks()).every((ink) => ink > 200), 'both figures', 20);
  assert.ok(await page.evaluate(() => document.querySelector('.left section:last-child').getBoundingClientRect().bottom <= innerHeight + 0.5));
  await picture('liked');
  await page.keyboard.press('Control+z');
  await said(/^undone: Old-Man$/, toast);
  await wears(await own());
  await until(async () => !(await styles()).includes('Old-Man'), 'the style to go');
});

test('twenty steps are taken back one by one, in a field they are its own', async () => {
  const names = await page.locator('[data-style]').evaluateAll((cards) => cards.slice(0, 3).map((c) => c.dataset.style));
  await card(names[0]).click();
  await wears(names[0]);
  const steps = await page.evaluate(() => globalThis.styled.app.undo.size);
  for (let i = 1; i <= 20; ++i) {
    await card(names[i % 3]).click();
    await wears(names[i % 3]);
    await until(() => page.evaluate((n) => globalThis.styled.app.undo.size === n, steps + i), 'the step');
  }
  await page.keyboard.press('Escape'); // panic
  await wears();
  await until(() => page.evaluate((n) => globalThis.styled.app.undo.size === n, steps + 21), 'the step');
  assert.match(await page.locator('.undo').getAttribute('title'), /^Undo: panic/);
  for (let i = 20; i >= 0; --i) {
    if (i % 2) await page.locator('.undo').click();
    else await page.keyboard.press('u');
    await wears(names[i % 3]);
    await until(() => page.evaluate((n) => globalThis.styled.app.undo.size === n, steps + i), 'the step to be gone');
  }
});

test('a drag is one step', async () => {
  const before = (await look()).strength;
  const knob = page.locator('input[name=strength]');
  for (const value of ['0.9', '0.7', '0.5']) await knob.fill(value);
  await until(async () => Math.abs((await look()).strength - 0.5) < 1e-3, 'the strength');
  await knob.press('Control+z');
  await until(async () => (await look()).strength === before, 'the strength before');
});

test('the performer is learnt from: countdown, take, style; Panic is heard meanwhile', async () => {
  await page.keyboard.press('l');
  await form().locator('input[name=style]').fill('shown');
  await form().locator('input[name=seconds]').fill('0');
  await form().locator('button[type=submit]').click();
  assert.match(await form().innerText(), /1 to 60 seconds/);
  await form().locator('input[name=seconds]').fill('8');
  await form().locator('button[type=submit]').click();
  const lesson = page.locator('.lesson');
  for (const number of ['3', '2', '1']) await until(async () => (await lesson.locator('strong').innerText()) === number, number);
  await picture('countdown');
  await until(async () => (await lesson.locator('strong').innerText()) === 'Go', 'the take');
  assert.match(await lesson.innerText(), /rig\.sim, act out shown/);
  await until(async () => (await lesson.locator('progress').evaluate((bar) => bar.value)) > 0.2, 'progress');
  await page.locator('.panic').evaluate((button) => button.click());
  await said(/^all performers are in bypass/, toast);
  assert.ok(await lesson.isVisible(), 'the take goes on');
  await picture('take');
  await said(/^shown is made from rig\.sim \(8\.0 s\)\./);
  await wears('shown');
  assert.ok(!(await lesson.isVisible()));
  await page.keyboard.press('Control+z');
  await until(async () => !(await styles()).includes('shown'), 'the style to go');
});

test('a take can be cancelled before and in it', async () => {
  await card(await own()).click();
  await wears(await own());
  for (const moment of ['3', 'Go']) {
    await until(() => page.locator('[data-example=learn]').isEnabled(), 'the last take to end');
    await page.keyboard.press('l');
    await form().locator('input[name=style]').fill('dropped');
    await form().locator('input[name=seconds]').fill('2');
    await form().locator('button[type=submit]').click();
    await until(async () => (await page.locator('.lesson strong').innerText()) === moment, moment);
    await page.locator('.lesson button').click();
    await said(/^dropped: cancelled$/);
    assert.ok(!(await page.locator('.lesson').isVisible()));
  }
  await until(() => page.locator('[data-example=learn]').isEnabled(), 'the end of the take');
  assert.ok(!(await styles()).includes('dropped'));
  await wears(await own());
});

test('mirror: on, back, and on the page', async () => {
  const button = page.locator('[data-mirror]');
  assert.equal(await button.getAttribute('aria-pressed'), 'false');
  await button.click();
  await until(async () => (await look()).mirror, 'the mirror');
  await until(async () => (await button.getAttribute('aria-pressed')) === 'true', 'the pressed button');
  await page.keyboard.press('Control+z');
  await until(async () => !(await look()).mirror, 'no mirror again');
});

test('all buttons of the performer are in sight, in one row at 720p', async () => {
  const outside = await page.evaluate(() => {
    const calibrate = document.querySelector('.acts > :last-child'); // some weights need it
    const shown = calibrate.hidden;
    calibrate.hidden = false;
    const panel = document.querySelector('.right').getBoundingClientRect();
    const rows = [...document.querySelectorAll('.acts button')].map((button) => [button.textContent, button.getBoundingClientRect()]);
    calibrate.hidden = shown;
    return rows.filter(([, box]) => box.width === 0 || box.right > panel.right - 4 || box.top !== rows[0][1].top).map(([name]) => name);
  });
  assert.deepEqual(outside, []);
});

test('a neutral take comes first', async () => {
  await page.keyboard.press('l');
  await form().locator('input[name=style]').fill('difference');
  await form().locator('input[name=seconds]').fill('1');
  await form().locator('input[name=neutral]').check();
  await form().locator('button[type=submit]').click();
  await until(async () => /move as usual/.test(await page.locator('.lesson').innerText()), 'the neutral take');
  await until(async () => /act out difference/.test(await page.locator('.lesson').innerText()), 'the other take');
  await said(/^difference is made from rig\.sim/);
  await page.keyboard.press('Control+z');
  await until(async () => !(await styles()).includes('difference'), 'the style to go');
});

test('variations: number, dice, amount, drift, each; back again', async () => {
  await card(await own()).click();
  const number = page.locator('input[name=vary]');
  await number.fill('7');
  await number.press('Enter');
  await until(async () => (await look()).vary === 7, 'variation 7');
  await number.fill('100');
  await number.press('Enter');
  await said(/whole number of 0 to 99/, toast);
  assert.equal((await look()).vary, 7);
  await page.locator('[data-vary=dice]').click();
  await until(async () => (await look()).vary !== 7, 'another one');
  await page.keyboard.press('Control+z');
  await until(async () => (await look()).vary === 7, 'variation 7 again');
  await page.locator('input[name=amount]').fill('0.5');
  await until(async () => (await look()).varyAmount === 0.5, 'the amount');
  await page.locator('input[name=drift]').fill('5');
  await until(async () => (await look()).driftS === 5, 'the drift');
  await page.locator('input[name=vary_each]').check();
  await until(async () => (await look()).varyEach, 'each its own');
  await picture('varied');
  for (let i = 0; i < 4; ++i) {
    await page.keyboard.press('u');
    await pause(300);
  }
  await until(async () => {
    const { vary, varyAmount, driftS, varyEach } = await look();
    return vary === 0 && varyAmount === 1 && driftS === 0 && !varyEach;
  }, 'the look before');
});

const menu = async (name, item) => {
  await page.locator(`[data-card="${name}"] .more`).click();
  if (item) await page.locator(`[data-menu=${item}]`).click();
};

test('what was made is renamed, exported, removed, brought back, and imported', async () => {
  await like('captain');
  await wears('captain');
  await menu('captain');
  await picture('menu');
  await page.keyboard.press('ArrowDown');
  assert.equal(await page.evaluate(() => document.activeElement.textContent), 'Export');
  await page.keyboard.press('Escape');
  await wears('captain'); // no panic
  await menu('captain', 'rename');
  const input = page.locator('.menu input');
  await input.fill(await own());
  await input.press('Enter');
  assert.match(await page.locator('.menu').innerText(), /name of the weights/);
  await input.fill('admiral');
  await input.press('Enter');
  await said(/^captain is now admiral$/, toast);
  await wears('admiral');
  await card('admiral').waitFor();
  await menu('admiral', 'export');
  await until(() => downloads.length === 1, 'the file', 20);
  const [download] = downloads.splice(0);
  assert.equal(download.suggestedFilename(), 'admiral.json');
  const saved = readFileSync(await download.path());
  assert.equal(JSON.parse(saved).name, 'admiral');
  await menu('admiral', 'remove');
  await said(/^admiral is removed; Undo restores it$/, toast);
  await wears();
  assert.ok(!readdirSync(file('library')).includes('admiral.json'));
  await page.keyboard.press('Control+z');
  await wears('admiral');
  assert.ok(readdirSync(file('library')).includes('admiral.json'));
  await menu('admiral', 'remove');
  await until(async () => !(await styles()).includes('admiral'), 'the style to go');
  await drop(page, ['whatever.json', saved]);
  await said(/^admiral is made from its file/);
  await card('admiral').waitFor();
  // Of the same name again: it asks, and Undo leads back.
  await drop(page, ['whatever.json', saved]);
  await until(async () => /Replaces admiral/.test(await form().innerText()), 'the question');
  await form().locator('button[type=submit]').click();
  await until(async () => !(await form().isVisible()), 'the answer');
  await drop(page, ['torn.json', saved.subarray(0, 60)]);
  await until(() => page.locator('.result.bad').isVisible(), 'the refusal');
});

test('the cards move, few times a second and only in view', async () => {
  await until(() => page.locator(`[data-style] canvas`).count(), 'a figure');
  await until(async () => (await page.locator('[data-style] canvas').count()) === (await page.locator('[data-style]').count()), 'all figures');
  await page.evaluate(() => (globalThis.pace_ms = 16));
  const pixels = () => page.locator('[data-style] canvas').first().evaluate((canvas) => canvas.toDataURL());
  const first = await pixels();
  await until(async () => (await pixels()) !== first, 'it to move');
  const count = () => page.evaluate(() => globalThis.styled.cards.figures.pictures);
  const begun = await count();
  await pause(2000);
  const cards = await page.locator('[data-style] canvas').count();
  assert.ok((await count()) - begun <= cards * 2 * 16 + cards, 'at most 15 a second');
  await page.getByText('Figures').click();
  await until(async () => (await page.locator('[data-style] canvas').count()) === 0, 'no figures');
  const still = await count();
  await pause(500);
  assert.equal(await count(), still);
  await page.getByText('Figures').click();
  await page.emulateMedia({ reducedMotion: 'reduce' });
  await until(() => page.locator('[data-style] canvas').count(), 'figures');
  await pause(1000);
  const stood = await count();
  await pause(500);
  assert.equal(await count(), stood, 'they stand');
  await page.emulateMedia({ reducedMotion: null });
  await page.evaluate(() => (globalThis.pace_ms = 400));
});

test('a thousand styles: found by name, pictured as they come into view', async () => {
  await page.evaluate(() => {
    const { app, client } = globalThis.styled;
    globalThis.honest = client.list;
    const info = app.list.styles.find(({ neutral }) => !neutral);
    const many = Array.from({ length: 1000 }, (_, i) => ({ ...info, name: `style-${i}`, aliases: [] }));
    globalThis.asked = [];
    client.list = async () => ({ ...app.list, styles: many });
    client.preview = async (style) => {
      globalThis.asked.push(style);
      throw new Error('not needed');
    };
    globalThis.styled.cards.previews.ask = (style) => {
      globalThis.asked.push(style);
      return new Promise((resolve) => setTimeout(() => resolve({
        rateHz: 10, joints: 21, positionsMm: Array.from({ length: 126 }, (_, i) => 40 * (i % 30)) }), 5));
    };
  });
  const begun = Date.now();
  await page.evaluate(() => globalThis.styled.app.fetchList());
  assert.equal(await page.locator('[data-style]').count(), 1000);
  assert.ok(Date.now() - begun < 5000, `${Date.now() - begun} ms`);
  await until(() => page.evaluate(() => globalThis.asked.length > 5), 'pictures');
  await pause(1000);
  const asked = await page.evaluate(() => globalThis.asked.length);
  assert.ok(asked < 100, `${asked} pictures were asked for`);
  await picture('thousand');
  await page.keyboard.press('/');
  await page.keyboard.type('LE-77');
  await until(async () => (await page.locator('[data-card]:not([hidden])').count()) === 11, 'those that match');
  assert.match(await page.locator('.find').innerText(), /11 of 1000/);
  await page.locator('.filter').fill('');
  await page.keyboard.press('Escape');
  await page.evaluate(async () => {
    globalThis.styled.client.list = globalThis.honest;
    await globalThis.styled.app.fetchList();
  });
});

test('a gateway for watching only offers nothing to change', async () => {
  const { web, address } = await startWeb('127.0.0.1:0', '--watch-only');
  const watcher = await open(address);
  await until(() => watcher.evaluate(() => globalThis.styled.app.performers().length > 0), 'a performer');
  for (const what of ['.examples', '.ask', '.lesson']) assert.ok(!(await watcher.locator(what).isVisible()), what);
  for (const what of ['.panic', '.undo', '[data-style] >> nth=0', 'input[name=strength]']) assert.ok(await watcher.locator(what).isDisabled(), what);
  assert.match(await watcher.locator('.right').innerText(), /For watching only/);
  await drop(watcher, ['walk.bvh', clip]);
  await until(async () => /watching only/.test(await watcher.locator('.toast').innerText()), 'the reason');
  await takePicture(watcher, 'watching');
  await watcher.close();
  web.kill('SIGKILL');
});

test('on a phone everything has its place', async () => {
  for (const [width, height] of [[390, 844], [1280, 720]]) {
    await page.setViewportSize({ width, height });
    await page.keyboard.press('l');
    await pause(500);
    const wide = await page.evaluate(() => [...document.querySelectorAll('button, input, select, .result, .ask')]
      .filter((element) => element.getClientRects().length > 0 && !element.closest('.styles'))
      .map((element) => [element.outerHTML.slice(0, 80), element.getBoundingClientRect()])
      .filter(([, { left, right }]) => left < -0.5 || right > innerWidth + 0.5).map(([text]) => text));
    assert.deepEqual(wide, []);
    assert.ok((await page.evaluate(() => document.documentElement.scrollWidth)) <= width);
    await picture(`examples-${width}`);
    await form().getByText('Cancel').click();
  }
});

test('everything that can be operated has a name', async () => {
  const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select, [role=button]')]
    .filter((element) => !element.hidden && !element.closest('[hidden]') && element.type !== 'file')
    .filter((element) => !(element.textContent.trim() || element.getAttribute('aria-label') || element.labels?.[0]?.textContent.trim()))
    .map((element) => element.outerHTML.slice(0, 100)));
  assert.deepEqual(nameless, []);
});

test('nothing went wrong within', () => {
  assert.deepEqual(errors, []);
  sim.kill('SIGKILL');
});
