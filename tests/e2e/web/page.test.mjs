// The page in a real browser, in front of the real gateway, daemon and simulator.
//   STYLED_BIN=build/release/bin CHROMIUM=/usr/bin/chromium node --test page.test.mjs
// SCREENSHOTS: a folder for screenshots.
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { makeAvatar } from './avatar.mjs';
import { readBvh, worldPositions } from './bvh.mjs';
import { drop, endAll, launch, patience, start, startAll, startDaemon, startWeb, takePicture, until } from './house.mjs';

let browser, page, sim, address, daemon, web;
const errors = [], downloads = [];

before(async () => {
  let udp;
  ({ daemon, udp } = await startAll('[presets]\nhalf_elderly = { elderly = 0.5 }\n'));
  sim = start('stylesim', '--to', `udp://${udp}`, '--rate', '120');
  ({ web, address } = await startWeb('127.0.0.1:0'));
  browser = await launch();
  page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.setDefaultTimeout(60000 * patience);
  page.on('download', (download) => downloads.push(download));
  page.on('pageerror', (error) => errors.push(error.message));
  page.on('console', (message) => {
    // The test itself causes refused connections while the gateway is down, and a broken texture.
    if (message.type() === 'error' && !/ERR_CONNECTION|WebSocket|Failed to load|Couldn't load texture blob/.test(message.text())) {
      errors.push(message.text());
    }
  });
  await page.goto(address);
});

after(() => endAll(browser));

// For the first performer: joints in metres and the frame's sequence, input and styled.
const poses = () =>
  page.evaluate(() => {
    const [performer] = globalThis.styled.stage.performers.values();
    const take = ({ figure, update }) =>
      figure && update && { joints: [...figure.joints], sequence: Number(update.frame.sequence) };
    return performer && { before: take(performer.roles.before), after: take(performer.roles.after) };
  });
const farthest = (a, b) => Math.max(...a.map((value, i) => Math.abs(value - b[i])));

// The largest difference of a joint between input and styled, at the same sequence.
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
const picture = (name) => takePicture(page, name);

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
  await page.locator('.pad').scrollIntoViewIfNeeded();
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
  const pressed = (root) => page.locator(`[data-root=${root}]`).getAttribute('aria-pressed');
  assert.equal(await pressed('follow'), 'true');
  for (const root of ['stride', 'follow']) {
    await page.locator(`[data-root=${root}]`).click();
    await until(async () => (await pressed(root)) === 'true', `the daemon to say that the root is "${root}"`);
  }
  await page.locator('[data-preset=half_elderly]').click();
  await until(async () => (await status()).styles.some(([style, weight]) => style === 'elderly' && weight === 0.5), 'the preset');
  await page.keyboard.press('2');
  const second = await page.locator('[data-style]').nth(1).getAttribute('data-style');
  await until(async () => (await status()).styles.some(([style, weight]) => style === second && weight === 1), 'the key');
  await page.keyboard.press('Escape');
  await until(async () => (await status()).styles.length === 0, 'panic');
});

test('a VRM avatar is worn and moves; a file that is none is said so', async () => {
  await drop(page, ['broken.vrm', Buffer.from('no avatar')]);
  const said = (words) => until(async () => words.test(await page.locator('.toast').innerText()), words);
  await said(/^broken\.vrm is not a VRM file: .*; expected a VRM 0\.x or 1\.0 avatar/);
  const whole = makeAvatar();
  await drop(page, ['half.vrm', whole.subarray(0, whole.length / 2)]);
  await said(/^half\.vrm is not complete: it has \d+ of \d+ bytes; expected/);
  // The length is correct, but a box refers to more vertices than the file contains.
  await drop(page, ['torn.vrm', Buffer.from(whole.toString('latin1').replace('"count":8,', '"count":9,'), 'latin1')]);
  await said(/^torn\.vrm .*; expected a VRM .*\(.+\)$/);
  await drop(page, ['torn picture.vrm', makeAvatar(Buffer.from('no picture'))]);
  await said(/wears torn picture\.vrm; one of its textures could not be loaded/);
  await page.getByTitle('Remove it').click();
  await drop(page, ['boxes.vrm', whole]);
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
  await page.getByTitle('Remove it').click();
  await until(async () => (await hand()) === undefined, 'no avatar');
});

// Stores the frames that arrive over the WebSocket from now on, independently of the recorder: per
// stream, by sequence.
const listen = () =>
  page.evaluate(() => {
    const heard = { source: [], rig: [] };
    globalThis.heard = heard;
    globalThis.styled.client.on('frame', ({ stream, frame, body }) => {
      if (globalThis.heard !== heard || !body || !heard[stream]) return; // the canonical one has another body
      heard[stream].push({ rig_s: Number(frame.sourceTimeNs) / 1e9, root: frame.rootPosition, rotations: frame.rotations });
      heard.body = { names: body.names, parents: body.parents, offsets: body.offsets };
    });
  });
const heard = () => page.evaluate(() => globalThis.heard);
const recorded = () => page.evaluate(() => globalThis.styled.recorder.frames);

async function saved(count) {
  await until(() => downloads.length === count, `${count} files`, 30);
  return Promise.all(downloads.splice(0).map(async (download) => {
    const text = readFileSync(await download.path(), 'utf8');
    return { name: download.suggestedFilename(), text };
  }));
}

// The file must match the received frames: each frame's time on the rig's clock, and its pose. A
// busy machine loses some frames, before or after the daemon: their grid steps must remain.
function assertHeard({ name, text }, stream, all) {
  const read = readBvh(text);
  const first_s = Math.max(all.source[0].rig_s, all.rig[0].rig_s);
  const last_s = Math.min(all.source.at(-1).rig_s, all.rig.at(-1).rig_s);
  const place = (rig_s) => Math.round(120 * (rig_s - first_s));
  const inside = all[stream].filter(({ rig_s }) => rig_s >= first_s && rig_s <= last_s);
  assert.equal(read.frames, place(last_s) + 1, name);
  assert.ok(Math.abs(read.frameTime_s - 1 / 120) < 1e-6, `${read.frameTime_s} s`);
  const filled = read.frames - inside.length;
  assert.equal(Number(/-(\d+)filled\.bvh$/.exec(name)?.[1] ?? 0), filled, name);
  assert.ok(inside.length > 0.5 * read.frames, `${inside.length} of ${read.frames} frames were heard`);
  for (const { rig_s, root, rotations } of inside) {
    const expected = worldPositions(all.body, root, rotations);
    const found = read.positions(place(rig_s));
    all.body.names.forEach((joint, i) => {
      const mm = 1000 * Math.hypot(...found.get(joint).map((x, axis) => x - expected[i][axis]));
      assert.ok(mm < 0.1, `${joint} is ${mm} mm off in frame ${place(rig_s)}`);
    });
  }
  return read;
}

test('what is recorded is what came, and both files are beside each other', async () => {
  await page.getByLabel('Formats to save').selectOption('styled input');
  await page.locator('[data-style=elderly]').click();
  await until(async () => (await apart()) > 0.04, 'another pose');
  await listen();
  await page.locator('button.record').click();
  await until(async () => (await recorded()) > 400, 'frames');
  assert.match(await page.locator('button.record').innerText(), /Stop · 0:0\d\.\d/);
  assert.match(await page.locator('.recording .hint').innerText(), /^\d+ frames/);
  assert.ok(await page.locator('.badge').isVisible());
  await picture('recording');
  await page.locator('button.record').click();
  const files = await saved(2);
  const all = await heard();
  assert.ok(!(await page.locator('.badge').isVisible()));
  await picture('recorded');
  const performer = await page.evaluate(() => globalThis.styled.app.selected);
  for (const [what, stream] of [['styled', 'rig'], ['input', 'source']]) {
    const file = files.find(({ name }) => name.startsWith(`${performer}-${what}-`));
    const read = assertHeard(file, stream, all);
    assert.ok(read.frames * read.frameTime_s > 3);
  }
  assert.match(await page.locator('.recording .hint').innerText(), /frames at 120 Hz/);
  // The last take can be saved again.
  await page.locator('[data-save=input]').click();
  const [again] = await saved(1);
  assert.equal(again.text, files.find(({ name }) => name === again.name).text);
});

test('from the keyboard: R begins and ends it, once however long it is held', async () => {
  await page.getByLabel('Formats to save').selectOption('styled');
  await page.locator('.stage canvas').focus();
  await listen();
  await page.keyboard.down('r');
  await page.keyboard.down('r'); // repeats
  await page.keyboard.down('r');
  await page.keyboard.up('r');
  await until(async () => (await recorded()) > 60, 'frames');
  await page.keyboard.press('r');
  const [file] = await saved(1);
  assertHeard(file, 'rig', await heard());
});

test('a list that was chosen from leaves the keys to the page; its own arrows stay its own', async () => {
  const list = page.getByLabel('Formats to save');
  const recording = () => page.evaluate(() => globalThis.styled.recorder.recording);
  const focused = () => list.evaluate((element) => document.activeElement === element);
  await list.click(); // opens it without a choice
  await page.keyboard.press('Escape');
  await page.keyboard.press('2');
  const second = await page.locator('[data-style]').nth(1).getAttribute('data-style');
  await until(async () => (await status()).styles.some(([style]) => style === second), 'the key of a style');
  await list.focus();
  await page.keyboard.press('ArrowDown');
  await until(async () => (await list.inputValue()) === 'styled input', 'the arrow to choose');
  assert.ok(await focused(), 'the arrows may go on');
  await list.click();
  await list.selectOption('styled');
  assert.ok(!(await focused()), 'the choice is made');
  await page.keyboard.press('r');
  await until(recording, 'R to record');
  await until(async () => (await recorded()) > 20, 'frames');
  await page.keyboard.press('r');
  await saved(1);
});

test('a video is drawn from what was recorded: 1080p, 60 pictures a second, as long as the take', async () => {
  await page.getByLabel('Formats to save').selectOption('video');
  await page.locator('button.record').click();
  await until(async () => (await recorded()) > 40, 'frames');
  await page.locator('button.record').click();
  // The span that all streams cover: one of them may begin or end a few frames later.
  const take_s = await page.evaluate(() => {
    const { source, styled, canonical } = globalThis.styled.recorder.take;
    const all = [source, styled, ...(canonical ? [canonical.track] : [])];
    return Math.min(...all.map((of) => of.rig_s(of.length - 1))) - Math.max(...all.map((of) => of.rig_s(0))) + 1 / 120;
  });
  await until(async () => /Cancel · \d+ %/.test(await page.locator('button.record').innerText()), 'the drawing to begin');
  await picture('rendering');
  await until(() => downloads.length === 1, 'the video', 240);
  const [file] = downloads.splice(0);
  assert.match(file.suggestedFilename(), /-video-[\d-]+\.(webm|mp4)$/);
  const words = await page.locator('.recording .hint').innerText();
  const [, pictures] = /video of (\d+) pictures at 60 Hz/.exec(words) ?? assert.fail(words);
  assert.ok(Math.abs(pictures / 60 - take_s) < 0.02, `${words} The streams have ${take_s} s in common.`);
  const base64 = readFileSync(await file.path()).toString('base64');
  // On a blank page, since the page's own policy permits only its own content.
  const blank = await browser.newPage();
  const seen = await blank.evaluate(async ([base64, pictures]) => {
    const video = document.createElement('video');
    video.muted = true;
    const came = (event) =>
      new Promise((resolve, reject) => {
        video.addEventListener(event, resolve, { once: true });
        video.addEventListener('error', () => reject(new Error('no video')), { once: true });
      });
    video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    await came('loadeddata');
    const drawing = new OffscreenCanvas(video.videoWidth, video.videoHeight).getContext('2d', { willReadFrequently: true });
    const looks = [];
    for (let picture = 0; picture < pictures; ++picture) {
      const sought = came('seeked');
      video.currentTime = (picture + 0.5) / 60;
      await sought;
      drawing.drawImage(video, 0, 0);
      const { data } = drawing.getImageData(0, 0, video.videoWidth, video.videoHeight);
      let bright = 0, sum = 0;
      for (let i = 0; i < data.length; i += 4) {
        bright += data[i] > 100;
        sum = (Math.imul(sum, 31) + data[i]) | 0;
      }
      looks.push({ bright, sum });
    }
    return { width: video.videoWidth, height: video.videoHeight, duration_s: video.duration, looks };
  }, [base64, Number(pictures)]);
  await blank.close();
  assert.deepEqual([seen.width, seen.height], [1920, 1080]);
  assert.ok(Math.abs(seen.duration_s - pictures / 60) < 0.02, `${seen.duration_s} s for ${pictures} pictures`);
  // No picture is black, and none is missing or another's copy, since the body moves in each.
  assert.ok(seen.looks.length > 15 && seen.looks.every(({ bright }) => bright > 2000), JSON.stringify(seen));
  assert.equal(new Set(seen.looks.map(({ sum }) => sum)).size, Number(pictures), 'the body moves');
  const shown = await page.evaluate(() => globalThis.styled.stage.pictures);
  await until(() => page.evaluate((n) => globalThis.styled.stage.pictures > n + 3, shown), 'the stage to be live again');
  await page.getByLabel('Formats to save').selectOption('styled');
});

test('the avatar alone is filmed on a transparent ground', async () => {
  await page.getByLabel('Formats to save').selectOption('alone');
  await page.locator('button.record').click();
  await until(async () => (await recorded()) > 40, 'frames');
  await page.locator('button.record').click();
  await until(() => downloads.length === 1, 'the video', 240);
  const [file] = downloads.splice(0);
  assert.match(file.suggestedFilename(), /-alone-[\d-]+\.webm$/);
  const bytes = readFileSync(await file.path());
  if (process.env.SCREENSHOTS) writeFileSync(`${process.env.SCREENSHOTS}/alone.webm`, bytes);
  const blank = await browser.newPage();
  // Of three pictures of the browser's own decoder: the shares of clear and of opaque pixels, and a sum.
  const seen = await blank.evaluate(async (base64) => {
    const video = document.createElement('video');
    const came = (event) => new Promise((resolve, reject) => {
      video.addEventListener(event, resolve, { once: true });
      video.addEventListener('error', () => reject(new Error('no video')), { once: true });
    });
    video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    await came('loadeddata');
    const pen = new OffscreenCanvas(video.videoWidth, video.videoHeight).getContext('2d', { willReadFrequently: true });
    const looks = [];
    for (const share of [0.1, 0.5, 0.9]) {
      const sought = came('seeked');
      video.currentTime = share * video.duration;
      await sought;
      pen.clearRect(0, 0, video.videoWidth, video.videoHeight);
      pen.drawImage(video, 0, 0);
      const { data } = pen.getImageData(0, 0, video.videoWidth, video.videoHeight);
      let clear = 0, opaque = 0, sum = 0;
      for (let i = 3; i < data.length; i += 4) {
        clear += data[i] < 8;
        opaque += data[i] > 247;
        sum = (Math.imul(sum, 31) + data[i]) | 0;
      }
      const pixels = data.length / 4;
      looks.push({ corner: data[3], clear: clear / pixels, opaque: opaque / pixels, sum });
    }
    return { width: video.videoWidth, height: video.videoHeight, looks };
  }, bytes.toString('base64'));
  await blank.close();
  assert.deepEqual([seen.width, seen.height], [1920, 1080]);
  for (const { corner, clear, opaque } of seen.looks) {
    assert.ok(corner < 8 && clear > 0.8 && opaque > 0.005 && clear + opaque > 0.98, JSON.stringify(seen));
  }
  assert.equal(new Set(seen.looks.map(({ sum }) => sum)).size, 3, 'it moves');
  const shown = await page.evaluate(() => globalThis.styled.stage.pictures);
  await until(() => page.evaluate((n) => globalThis.styled.stage.pictures > n + 3, shown), 'the stage to be live again');
  await page.getByLabel('Formats to save').selectOption('styled');
});

test('a daemon that dies ends the recording; what was got is saved', async () => {
  await listen();
  await page.locator('button.record').click();
  await until(async () => (await recorded()) > 120, 'frames');
  daemon.kill('SIGKILL');
  const [file] = await saved(1);
  const read = assertHeard(file, 'rig', await heard());
  assert.ok(read.frames > 100);
  assert.match(await page.locator('.recording .hint').innerText(), /Recording ended: the daemon went away/);
  assert.ok(await page.locator('button.record').isDisabled());
  assert.match(await page.locator('button.record').getAttribute('title'), /daemon is away/);
  await page.keyboard.press('r');
  await until(async () => /nothing to record/.test(await page.locator('.toast').innerText()), 'the reason');
  daemon = await startDaemon();
  await until(() => page.locator('button.record').isEnabled(), 'the button again');
});

test('a daemon that dies is missed, and found again', async () => {
  const figures = () => page.locator('.plot output').allInnerTexts();
  await until(async () => / Hz$/.test((await figures())[1]), 'figures');
  assert.match((await figures())[0], /^[\d.]+ \/ [\d.]+ ms$/);
  daemon.kill('SIGKILL');
  await until(async () => /daemon is away/i.test(await page.locator('.banner').innerText()), 'the banner');
  await until(async () => (await figures()).join() === 'no data,no data,no data', 'the plots to say so');
  assert.equal(await page.locator('.plot.nodata').count(), 3);
  await picture('away');
  daemon = await startDaemon();
  await until(async () => / Hz$/.test((await figures())[1]) && (await page.locator('.plot.nodata').count()) === 0, 'figures again');
  await until(async () => !(await page.locator('.banner').isVisible()), 'the banner to go');
  const first = await poses();
  await until(async () => farthest((await poses()).after.joints, first.after.joints) > 0.05, 'motion');
});

test('a gateway that dies is missed, and found again', async () => {
  const listen = address.slice('http://'.length);
  web.kill('SIGKILL');
  await web.ended;
  await until(async () => /gateway is away/i.test(await page.locator('.banner').innerText()), 'the banner');
  ({ web } = await startWeb(listen));
  await until(async () => !(await page.locator('.banner').isVisible()), 'the banner to go');
  const first = await poses();
  await until(async () => farthest((await poses()).after.joints, first.after.joints) > 0.05, 'motion');
});

test('cues and calibration go through the gateway to the daemon, which knows better', async () => {
  const refusal = (call, ...args) =>
    page.evaluate(([call, args]) => globalThis.styled.client[call](...args).then(() => 'done', ({ name, message }) => `${name}: ${message}`),
      [call, args]);
  assert.match(await refusal('cue', 'act ten'), /^RefusedError: no cue/);
  const performer = await page.evaluate(() => globalThis.styled.app.selected);
  assert.match(await refusal('calibrate', performer, { pose: 'n' }), /^RefusedError: /); // it walks
  assert.equal(await refusal('calibrate', performer, { clear: true }), 'done');
});

test('whom the daemon lists is not called unknown', async () => {
  await page.evaluate(() => {
    const { client } = globalThis.styled;
    globalThis.complaints = [];
    client.on('complaint', (text, unknown) => globalThis.complaints.push(unknown));
    globalThis.said = [];
    new MutationObserver(() => globalThis.said.push(document.querySelector('.toast').textContent))
      .observe(document.querySelector('.toast'), { childList: true, characterData: true, subtree: true });
  });
  // Configured in advance, so it is listed; it never sends a frame.
  await page.evaluate(() => globalThis.styled.client.set('rig.nobody', { strength: 0.5 }));
  await page.locator('[data-performer="rig.nobody"]').waitFor();
  await until(() => page.evaluate(() => globalThis.complaints.includes('rig.nobody')), "the client's complaint");
  assert.match(await page.locator('[data-performer="rig.nobody"]').innerText(), /silent/);
  assert.deepEqual(await page.evaluate(() => globalThis.said.filter((text) => /found no performer/.test(text))), []);
  // For an unlisted name there is a message.
  await page.evaluate(() => globalThis.styled.client.subscribe('rig.nobdoy'));
  await until(() => page.evaluate(() => globalThis.said.some((text) => /found no performer rig\.nobdoy/.test(text))), 'the complaint');
});

test('the row from the rig to the reader is in order, and names the link where the rig falls silent', async () => {
  await page.locator('[data-why]').click();
  const links = () => page.locator('.chain li').evaluateAll((all) => all.map((link) => `${link.children[1].textContent} ${link.dataset.state}`).join());
  await until(async () => /^Rig ok,Port ok,Body ok,.*Reader ok$/.test(await links()), 'a row that is in order');
  await picture('why');
  sim.kill('SIGSTOP');
  await until(async () => /^Rig bad,Port ok,.*Reader off$/.test(await links()), 'the broken link');
  sim.kill('SIGCONT');
  await until(async () => /^Rig ok,Port ok,Body ok,.*Reader ok$/.test(await links()), 'the row to be in order again');
  await page.keyboard.press('Escape');
});

test('a daemon that does not answer in time may still do what it was asked', async () => {
  daemon.kill('SIGSTOP');
  try {
    await page.locator('[data-style]').nth(2).click();
    await until(async () => /; it may still be applied$/.test(await page.locator('.toast').innerText()), 'the warning');
  } finally {
    daemon.kill('SIGCONT');
  }
  await until(async () => !(await page.locator('.banner').isVisible()), 'the banner to go');
});

test('nothing is cut off or over another, however small the window', async () => {
  for (const [width, height] of [[1280, 720], [1024, 600], [420, 800]]) {
    await page.setViewportSize({ width, height });
    const found = await page.evaluate(async () => {
      await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
      const rows = [document.querySelector('header'), ...document.querySelectorAll('.plot figcaption')];
      // Readings of the maximum length.
      const long = ['1234 / 12345 ms', '119.9 Hz', '120 / 120 per s'];
      [...document.querySelectorAll('.plot output')].forEach((output, i) => (output.textContent = long[i]));
      const wrong = [];
      for (const row of rows) {
        const box = row.getBoundingClientRect();
        if (box.right > innerWidth + 0.5) wrong.push(`${row.textContent}: to ${box.right} of ${innerWidth}`);
        let end = box.left;
        for (const child of row.children) {
          const { left, right, width } = child.getBoundingClientRect();
          if (width === 0) continue;
          if (left < end - 0.5 || right > box.right + 0.5) wrong.push(`${child.textContent}: ${left} to ${right}, after ${end} in ${box.right}`);
          end = right;
        }
      }
      for (const output of document.querySelectorAll('.plot output')) {
        if (innerWidth >= 1280 && output.scrollWidth > output.clientWidth) wrong.push(`${output.textContent}: cut off`);
      }
      if (document.documentElement.scrollWidth > innerWidth) wrong.push(`the page is ${document.documentElement.scrollWidth} wide`);
      return wrong;
    });
    await picture(`${width}x${height}`);
    assert.deepEqual(found, [], `${width} x ${height}`);
  }
  await page.setViewportSize({ width: 1280, height: 720 });
});

test('nothing went wrong within', () => assert.deepEqual(errors, []));
