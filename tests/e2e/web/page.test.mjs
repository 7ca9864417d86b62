// The page in a real browser, in front of the real gateway, daemon and simulator.
//   STYLED_BIN=build/release/bin CHROMIUM=/usr/bin/chromium node --test page.test.mjs
// SCREENSHOTS: a folder where pictures are left.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { chromium } from 'playwright-core';

import { makeAvatar } from './avatar.mjs';

const bin = process.env.STYLED_BIN;
const folder = mkdtempSync(path.join(os.tmpdir(), 'styled-page-'));
const file = (name) => path.join(folder, name);
const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const children = new Set();
let browser, page, address, daemon, web;
const errors = [];

async function until(condition, what, seconds = 60) {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await pause(50)) {
    if (await condition()) return;
  }
  throw new Error(`waited in vain for ${what}`);
}

function start(program, ...options) {
  const child = spawn(path.join(bin, program), options, { stdio: ['ignore', 'ignore', 'inherit'] });
  children.add(child);
  child.ended = new Promise((resolve) => child.once('exit', resolve));
  return child;
}

async function startDaemon() {
  rmSync(file('ready.json'), { force: true });
  daemon = start('styled', '--config', file('styled.toml'), '--ready-file', file('ready.json'),
    '--set', 'log.level=warn', '--set', 'realtime.lock_memory=false');
  await until(() => existsSync(file('ready.json')), 'the daemon');
}

async function startWeb(listen) {
  rmSync(file('web.json'), { force: true });
  web = start('styleweb', '--listen', listen, '--publish', `ipc://${file('publish')}`,
    '--control', `ipc://${file('control')}`, '--ready-file', file('web.json'));
  await until(() => existsSync(file('web.json')), 'styleweb');
  address = JSON.parse(readFileSync(file('web.json'), 'utf8')).listen;
}

// The port of a first start is kept, so that the simulator finds the daemon again.
async function startAll() {
  const config = (udp) => writeFileSync(file('styled.toml'), `[[source]]
name = "rig"
type = "udp"
listen = "${udp}"
[publish]
address = "ipc://${file('publish')}"
[control]
address = "ipc://${file('control')}"
[presets]
half_elderly = { elderly = 0.5 }
`);
  config('127.0.0.1:0');
  await startDaemon();
  const udp = JSON.parse(readFileSync(file('ready.json'), 'utf8')).sources[0].listen;
  config(udp);
  start('stylesim', '--to', `udp://${udp}`, '--rate', '120');
  await startWeb('127.0.0.1:0');
}

before(async () => {
  await startAll();
  browser = await chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });
  page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.setDefaultTimeout(60000);
  page.on('pageerror', (error) => errors.push(error.message));
  page.on('console', (message) => {
    // Refused connections while the gateway is away are the test's own doing.
    if (message.type() === 'error' && !/ERR_CONNECTION|WebSocket|Failed to load/.test(message.text())) {
      errors.push(message.text());
    }
  });
  await page.goto(address);
});

after(async () => {
  await browser?.close();
  for (const child of children) child.kill('SIGKILL');
  rmSync(folder, { recursive: true, force: true });
});

// Of the first performer: joints in metres and the frame's sequence, before and after.
const poses = () =>
  page.evaluate(() => {
    const [performer] = globalThis.styled.stage.performers.values();
    const take = ({ figure, update }) =>
      figure && update && { joints: [...figure.joints], sequence: Number(update.frame.sequence) };
    return performer && { before: take(performer.roles.before), after: take(performer.roles.after) };
  });
const farthest = (a, b) => Math.max(...a.map((value, i) => Math.abs(value - b[i])));

// The largest difference of a joint between before and after, at one sequence.
async function apart() {
  let found;
  await until(async () => {
    const now = await poses();
    if (!now?.before || !now.after || now.before.sequence !== now.after.sequence) return false;
    found = farthest(now.before.joints, now.after.joints);
    return true;
  }, 'both poses of one sequence');
  return found;
}

const status = () =>
  page.evaluate(async () => {
    const { stats } = await globalThis.styled.client.status();
    const [performer] = stats.performers;
    return { styles: performer.styles.map(({ style, weight }) => [style, weight]), strength: performer.strength,
             only: performer.only };
  });

const stagePicture = () => page.locator('.stage canvas').screenshot();
async function picture(name) {
  if (process.env.SCREENSHOTS) await page.screenshot({ path: path.join(process.env.SCREENSHOTS, `${name}.png`) });
}

test('two bodies move', async () => {
  await until(async () => (await poses())?.after, 'two bodies');
  const first = await poses();
  assert.equal(first.before.joints.length, first.after.joints.length);
  const picture1 = await stagePicture();
  await until(async () => {
    const now = await poses();
    return farthest(now.before.joints, first.before.joints) > 0.1 && farthest(now.after.joints, first.after.joints) > 0.1;
  }, 'both to move');
  assert.ok(!picture1.equals(await stagePicture()), 'the picture changed');
  assert.match(await page.locator('.state').innerText(), /live/);
  const pictures = await page.evaluate(() => globalThis.styled.stage.pictures);
  await until(() => page.evaluate((n) => globalThis.styled.stage.pictures > n + 20, pictures), 'more pictures');
});

test('in bypass both bodies are the same', async () => {
  assert.ok((await apart()) < 1e-4);
});

test('a click on a style changes the daemon, and the body', async () => {
  await page.locator('[data-style=elderly]').click();
  await until(async () => (await status()).styles.some(([style, weight]) => style === 'elderly' && weight === 1), 'the style');
  await until(async () => (await apart()) > 0.04, 'another pose');
  await until(async () => (await page.locator('[data-style=elderly]').getAttribute('aria-pressed')) === 'true', 'the button');
  assert.match(await page.locator('.label.after').first().innerText(), /elderly/);
  await picture('styled');
});

test('strength 0 makes both bodies one again', async () => {
  const knob = page.locator('input[name=strength]');
  await knob.fill('0');
  await until(async () => (await status()).strength === 0, 'the strength');
  await until(async () => (await apart()) < 1e-4, 'both bodies to be the same');
  await knob.fill('1');
  await until(async () => (await apart()) > 0.04, 'another pose again');
});

test('mix pad, body parts, preset and keys reach the daemon', async () => {
  await page.getByLabel('first style of the mix').selectOption('elderly');
  await page.getByLabel('second style of the mix').selectOption('youthful');
  const pad = await page.locator('.pad').boundingBox();
  await page.mouse.click(pad.x + 0.25 * pad.width, pad.y + 0.5 * pad.height);
  await until(async () => {
    const now = new Map((await status()).styles);
    return Math.abs((now.get('elderly') ?? 0) - 0.75) < 0.03 && Math.abs((now.get('youthful') ?? 0) - 0.25) < 0.03;
  }, 'the mix');
  await page.locator('[data-part=head]').click();
  await until(async () => (await status()).only.length === 5, 'all parts but the head');
  await page.locator('[data-part=head]').click();
  await until(async () => (await status()).only.length === 0, 'all parts');
  await page.locator('[data-preset=half_elderly]').click();
  await until(async () => (await status()).styles.some(([style, weight]) => style === 'elderly' && weight === 0.5), 'the preset');
  await page.keyboard.press('2');
  const second = await page.locator('[data-style]').nth(1).getAttribute('data-style');
  await until(async () => (await status()).styles.some(([style, weight]) => style === second && weight === 1), 'the key');
  await page.keyboard.press('Escape');
  await until(async () => (await status()).styles.length === 0, 'panic');
});

test('a VRM avatar is worn and moves; a file that is none is said so', async () => {
  const drop = (name, bytes) =>
    page.evaluate(([name, base64]) => {
      const transfer = new DataTransfer();
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
      dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true, bubbles: true }));
    }, [name, bytes.toString('base64')]);
  await drop('broken.vrm', Buffer.from('no avatar'));
  await until(async () => /broken.vrm cannot be read/.test(await page.locator('.toast').innerText()), 'the reason');
  await drop('boxes.vrm', makeAvatar());
  const hand = () =>
    page.evaluate(() => {
      const [performer] = globalThis.styled.stage.performers.values();
      if (!performer.avatar?.ready) return undefined;
      const place = performer.avatar.place('leftHand');
      return { place: place.toArray(), capsules: performer.roles.after.figure.group.visible };
    });
  await until(hand, 'the avatar');
  await until(async () => (await hand()).capsules === false, 'the capsules to go');
  const first = await hand();
  assert.ok(first.place[1] > 0.2 && first.place[1] < 1.4, `a hand at ${first.place}`);
  await until(async () => farthest((await hand()).place, first.place) > 0.05, 'the hand to move');
  await picture('avatar');
  await page.getByTitle('Take it off').click();
  await until(async () => (await hand()) === undefined, 'no avatar');
});

test('a daemon that dies is missed, and found again', async () => {
  daemon.kill('SIGKILL');
  await until(async () => /daemon is away/i.test(await page.locator('.banner').innerText()), 'the banner');
  await picture('away');
  await startDaemon();
  await until(async () => !(await page.locator('.banner').isVisible()), 'the banner to go');
  const first = await poses();
  await until(async () => farthest((await poses()).after.joints, first.after.joints) > 0.05, 'motion');
});

test('a gateway that dies is missed, and found again', async () => {
  const listen = address.slice('http://'.length);
  web.kill('SIGKILL');
  await web.ended;
  await until(async () => /gateway is away/i.test(await page.locator('.banner').innerText()), 'the banner');
  await startWeb(listen);
  await until(async () => !(await page.locator('.banner').isVisible()), 'the banner to go');
  const first = await poses();
  await until(async () => farthest((await poses()).after.joints, first.after.joints) > 0.05, 'motion');
});

test('nothing went wrong within', () => assert.deepEqual(errors, []));
