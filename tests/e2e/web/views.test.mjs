// The page as OBS, a phone and a screen reader meet it: one real browser, in front of the real gateway
// with a token; the rig is one of VMC, whose face is sent from here.
//   STYLED_BIN=build/release/bin CHROMIUM=/usr/bin/chromium node --test views.test.mjs
// SCREENSHOTS: a folder for screenshots. PATIENCE: factor of all waits.
import assert from 'node:assert/strict';
import { createSocket } from 'node:dgram';
import { readFileSync, writeFileSync } from 'node:fs';
import { after, before, test } from 'node:test';

import { makeAvatar } from './avatar.mjs';
import { axeOf, drawSeldom, drop, endAll, file, launch, patience, start, startAll, startWeb, takePicture, until } from './house.mjs';

const TOKEN = 'a-token-of-this-test';
let browser, page, address, vmc, rig, link, panels, poor, lines; // `poor`: a browser without WebGL, and its page
const violations = async (within) => (await axeOf(page))(within);
const errors = [];
const panelsOf = (of) => of.evaluate(() => [...document.querySelectorAll('#app h2')].filter((title) => title.checkVisibility()).map((title) => title.textContent));
// The panels that are out of sight in whole or in part; the lists of performers and styles scroll within theirs.
const hiddenPanels = (of) => of.evaluate(async () => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  return [...document.querySelectorAll('#app section:not(.version), .plot, .stage')].filter((panel) => panel.checkVisibility()).filter((panel) => {
    const { top, bottom, left, right } = panel.getBoundingClientRect();
    return top < 0 || bottom > innerHeight + 0.5 || left < 0 || right > innerWidth + 0.5 || (panel.scrollHeight > panel.clientHeight + 1);
  }).map((panel) => `${panel.className}: ${panel.textContent.slice(0, 40)}`);
});

before(async () => {
  await startAll('[[source]]\nname = "face"\ntype = "vmc"\nlisten = "127.0.0.1:0"\nperformer = "mia"\n' +
    '[presets]\nhalf_elderly = { elderly = 0.5 }\nproud_walk = { proud = 1.0 }\n' +
    '[[cue]]\nname = "act_one"\nstyle = "elderly"\n[[cue]]\nname = "act_two"\nstyle = "proud"\n');
  vmc = JSON.parse(readFileSync(file('ready.json'), 'utf8')).sources[1].listen.replace(/^\w+:\/\//, '');
  rig = await relay();
  start('stylesim', '--as', 'vmc', '--to', `udp://${rig.address}`, '--rate', '30', '--script', 'walk:5,turn-left:1');
  writeFileSync(file('token'), TOKEN, { mode: 0o600 });
  const { address: far } = await startWeb('0.0.0.0:0', '--token-file', file('token'));
  address = `http://far.test:${far.split(':').at(-1)}`; // as from another machine: no loopback name, no TLS
  browser = await launch(['--host-resolver-rules=MAP far.test 127.0.0.1']);
  page = await browser.newPage({ viewport: { width: 390, height: 844 }, hasTouch: true, colorScheme: 'dark' });
  page.setDefaultTimeout(60000 * patience);
  page.on('pageerror', (error) => errors.push(error.message));
  page.on('console', (message) => {
    // A page that is left while it connects reports it.
    if (message.type() === 'error' && !/WebSocket is closed before/.test(message.text())) errors.push(message.text());
  });
  await drawSeldom(page, 1000);
  await page.goto(`${address}/#token=${TOKEN}`);
  await until(() => page.evaluate(() => globalThis.styled.app.live().length === 1 && globalThis.styled.app.list), 'a performer');
});

after(async () => {
  await poor?.close();
  await endAll(browser);
});

// The rig's datagrams pass through here, so that its face comes from the same sender.
function relay() {
  const socket = createSocket('udp4');
  const [host, port] = vmc.split(':');
  socket.on('message', (bytes) => socket.send(bytes, Number(port), host));
  socket.unref();
  return new Promise((resolve) => socket.bind(0, '127.0.0.1', () => resolve({
    address: `127.0.0.1:${socket.address().port}`, send: (bytes) => socket.send(bytes, Number(port), host),
  })));
}

// A face as VMC's OSC messages.
function sendFace(values) {
  const text = (words) => Buffer.from(words + '\0'.repeat(4 - (words.length % 4)));
  const number = (value) => {
    const bytes = Buffer.alloc(4);
    bytes.writeFloatBE(value);
    return bytes;
  };
  for (const [name, value] of Object.entries(values)) {
    rig.send(Buffer.concat([text('/VMC/Ext/Blend/Val'), text(',sf'), text(name), number(value)]));
  }
  rig.send(Buffer.concat([text('/VMC/Ext/Blend/Apply'), text(',')]));
}

// Of the picture: how many pixels are opaque, how many are seen through, the corner's RGBA, and the share of the
// height that has opaque ones.
async function pixels() {
  const png = await page.screenshot({ omitBackground: true });
  const found = await page.evaluate(async (base64) => {
    const image = await createImageBitmap(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    const drawing = new OffscreenCanvas(image.width, image.height).getContext('2d');
    drawing.drawImage(image, 0, 0);
    const { data } = drawing.getImageData(0, 0, image.width, image.height);
    let opaque = 0, clear = 0, top = image.height, bottom = 0;
    const { width, height } = image;
    const corners = [0, width - 1, width * (height - 1), width * height - 1].map((i) => data[4 * i + 3]);
    for (let i = 3; i < data.length; i += 4) {
      opaque += data[i] === 255;
      clear += data[i] === 0;
      if (data[i] !== 255) continue;
      const row = Math.floor(i / 4 / image.width);
      top = Math.min(top, row);
      bottom = Math.max(bottom, row);
    }
    return { opaque, clear, all: data.length / 4, corner: [...data.slice(0, 4)], corners, tall: (bottom - top) / image.height,
             top: top / image.height };
  }, png.toString('base64'));
  return { ...found, png };
}
const wornAlone = () => page.evaluate(() => [...globalThis.styled.stage.performers.values()][0]?.avatar?.ready === true);

test('on a phone Panic stays in sight, and everything is large enough for a finger', async () => {
  const small = await page.evaluate(() =>
    [...document.querySelectorAll('button, select, input, [role=button]')]
      .map((element) => (element.type === 'checkbox' ? element.closest('label') : element))
      .filter((element) => element.checkVisibility())
      .map((element) => [element.textContent || element.getAttribute('aria-label') || element.name, element.getBoundingClientRect()])
      .filter(([, { width, height }]) => width < 43.5 || height < 43.5)
      .map(([name, { width, height }]) => `${name}: ${width} x ${height}`));
  await takePicture(page, 'phone');
  assert.deepEqual(small, []);
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  // Without a scroll: the performers under the picture, then styles in the lower half, where a thumb reaches.
  const { y: chip, height: tall } = await page.locator('[data-performer]').boundingBox();
  const picture = await page.locator('.stage').boundingBox();
  assert.ok(chip > picture.y + picture.height && chip + tall < 844 / 2, `the performer is at ${chip}`);
  const { y: card } = await page.locator('[data-style]').nth(5).boundingBox();
  assert.ok(card > 844 / 2 && card < 844 - 44, `the sixth style is at ${card}`);
  const shown = () => page.locator('.plot').first().isVisible();
  assert.ok(!(await shown()), 'plots are folded');
  await page.locator('.fold').click();
  assert.ok(await shown(), 'they unfold');
  await page.locator('.fold').click();
  await page.locator('.version .about').click();
  assert.match(await page.locator('dialog[open]').innerText(), /icences/, 'version and licences are at the end');
  await page.keyboard.press('Escape');
  await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
  const { y, height } = await page.locator('.panic').boundingBox();
  assert.ok(y >= 0 && y + height <= 60, `Panic is at ${y}`);
  await takePicture(page, 'phone below');
  await page.locator('.panic').click();
  await until(async () => /all performers are in bypass/.test(await page.locator('.toast').textContent()), 'panic');
});

test('no violation of WCAG A or AA; the help is a dialog', async () => {
  assert.deepEqual(await violations(), [], 'phone');
  await page.evaluate(() => document.querySelector('.state').insertAdjacentHTML('beforeend', '<img src="/icon.svg" class="unnamed">'));
  assert.match((await violations()).join(), /^image-alt: \.unnamed: /, 'it would be found');
  await page.evaluate(() => document.querySelector('.unnamed').remove());
  await page.setViewportSize({ width: 1280, height: 720 });
  assert.deepEqual(await violations(), [], 'desk');
  panels = await panelsOf(page);
  const focused = () => page.evaluate(() => document.querySelector('dialog[open]')?.contains(document.activeElement));
  await page.getByRole('button', { name: 'Keys' }).click();
  assert.ok(await focused());
  for (let i = 0; i < 3; ++i) {
    await page.keyboard.press('Tab');
    assert.notEqual(await page.evaluate(() => document.querySelector('#app main').contains(document.activeElement)), true);
  }
  assert.deepEqual(await violations('dialog[open]'), [], 'help');
  await takePicture(page, 'help');
  const said = await page.locator('.toast').textContent();
  await page.keyboard.press('b'); // the page's keys are not for a dialog
  await page.keyboard.press('Escape');
  assert.equal(await focused(), undefined, 'closed');
  assert.equal(await page.locator('.toast').textContent(), said, 'neither bypass nor panic');
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute('aria-label')), 'Keys');
  await page.getByRole('button', { name: 'Drop a .vrm here' }).focus();
  await page.keyboard.press('?');
  assert.ok(await focused());
  await page.keyboard.press('?');
  assert.equal(await focused(), undefined);
});

test('the page links to OBS: avatar, performer, token; a phone gets a code', async () => {
  await drop(page, ['Mia v2.vrm', makeAvatar(undefined, { presets: ['happy', 'blink', 'blinkLeft', 'blinkRight'], details: true })]);
  await until(async () => /wears Mia v2\.vrm$/.test(await page.locator('.toast').innerText()), 'the avatar to be worn');
  assert.ok(!page.url().includes(TOKEN), 'the token is not left in the address');
  await page.locator('button.links').click();
  await page.getByLabel('Framing').selectOption('bust');
  await page.locator('input[name=mirror]').check();
  assert.match(await page.locator('[data-link=obs]').inputValue(), /&frame=bust&mirror=1#/);
  await page.getByLabel('Framing').selectOption('');
  await page.locator('input[name=mirror]').uncheck();
  await page.locator('[data-copy=obs]').click();
  await until(async () => (await page.locator('.copied .hint').first().innerText()) === 'Copied.', 'the copy');
  link = await page.locator('[data-link=obs]').inputValue();
  assert.equal(link, `${address}/?view=avatar&performer=face.mia&avatar=Mia+v2.vrm&bg=transparent#token=${TOKEN}`);
  assert.equal(await page.locator('[data-link=page]').inputValue(), `${address}/#token=${TOKEN}`);
  assert.ok((await page.locator('.qr').boundingBox()).width > 200);
  assert.match(await page.locator('.share').innerText(), /Anyone who has one can do everything that you can do here\./);
  assert.deepEqual(await violations('dialog[open]'), [], 'links');
  await takePicture(page, 'share');
  await page.keyboard.press('Escape');
  assert.ok(!(await page.locator('.share').isVisible()));
});

test('OBS sees the avatar alone, through a transparent page, with its face', async () => {
  await page.setViewportSize({ width: 480, height: 270 });
  await page.goto('about:blank');
  await page.goto(link);
  await until(wornAlone, 'the avatar');
  let seen;
  await until(async () => (seen = await pixels()).opaque > 0, 'a picture');
  const { opaque, clear, all, corner, png, tall } = seen;
  if (process.env.SCREENSHOTS) writeFileSync(`${process.env.SCREENSHOTS}/obs.png`, png);
  assert.deepEqual(corner, [0, 0, 0, 0]);
  // This avatar's boxes are small: what tells it from a speck is its height.
  assert.ok(tall > 0.4 && tall < 0.9, `the avatar is ${tall} of the picture's height`);
  assert.ok(opaque > 0.005 * all && opaque < 0.3 * all, `${opaque} of ${all} are the avatar`);
  assert.ok(clear > 0.6 * all, `${clear} of ${all} are seen through`);
  const face = () =>
    page.evaluate(() => Object.fromEntries([...globalThis.styled.stage.performers.values()][0].avatar.face));
  await until(async () => {
    sendFace({ Joy: 0.75, Blink_L: 1 });
    return (await face()).happy === 0.75;
  }, 'the face');
  assert.deepEqual(await face(), { happy: 0.75, blinkLeft: 1 });
  assert.ok(!(await page.locator('.note').isVisible()), 'no words on air');
});

test('OBS is given bust or half, mirrored, through a transparent page, with and without an avatar', async () => {
  // From the hips to the head, in half heights of the picture: how near the body is, whatever it does.
  const height = () => page.evaluate(() => {
    const { camera, performers } = globalThis.styled.stage;
    const { joints, group, skeleton } = [...performers.values()][0].roles.after.figure;
    const [hips, head] = [0, skeleton.joints.findIndex(({ part }) => part === 'head')].map((joint) =>
      camera.position.clone().fromArray(joints, 3 * joint).applyMatrix4(group.matrixWorld).project(camera).y);
    return head - hips;
  });
  const heights = {};
  for (const frame of ['half', 'bust']) {
    await page.goto('about:blank');
    await page.goto(link.replace('&avatar=Mia+v2.vrm', '').replace('&bg', `&frame=${frame}&mirror=1&bg`));
    let seen;
    await until(async () => (seen = await pixels()).opaque > 0, 'a picture');
    if (process.env.SCREENSHOTS) writeFileSync(`${process.env.SCREENSHOTS}/obs ${frame}.png`, seen.png);
    assert.deepEqual(seen.corners, [0, 0, 0, 0], frame);
    assert.ok(seen.top > 0.04 && seen.top < 0.25 && seen.top + seen.tall > 0.99, `${frame}: ${seen.tall} of the height from ${seen.top}`);
    heights[frame] = await height();
    assert.equal(await page.locator('.stage canvas').evaluate((canvas) => getComputedStyle(canvas).transform), 'matrix(-1, 0, 0, 1, 0, 0)');
  }
  assert.ok(heights.half > 0.5 && heights.bust > 1.3 * heights.half, `a bust is nearer: ${heights.bust}, half ${heights.half}`);
  // The avatar's head in the same place of the picture, whatever the size of the avatar.
  await page.goto('about:blank');
  await page.goto(link.replace('&bg', '&frame=bust&bg'));
  await until(wornAlone, 'the avatar');
  await until(async () => {
    const seen = await pixels();
    return seen.opaque > 0 && seen.top > 0.02 && seen.top < 0.3 && seen.corners.every((alpha) => alpha === 0);
  }, "the avatar's head", 20);
});

test('an avatar that OBS does not have is asked for, and kept under the name of the link', async () => {
  await page.goto(link.replace('Mia+v2', 'other').replace('transparent', '00ff00'));
  const shown = () => page.evaluate(() => [...globalThis.styled.stage.performers.values()][0]?.roles.after.figure !== undefined);
  await until(shown, 'a body');
  await page.mouse.move(20, 20);
  await page.mouse.move(40, 20);
  assert.match(await page.locator('.note').innerText(), /^avatar other\.vrm is not on this browser: click/);
  await page.evaluate(() => document.querySelector('input[type=file]').addEventListener('click', () => (globalThis.asked = true)));
  await page.mouse.click(300, 180);
  await until(() => page.evaluate(() => globalThis.asked), 'the choice of a file');
  await page.locator('input[type=file]').setInputFiles({ name: 'mine.vrm', mimeType: 'model/gltf-binary', buffer: makeAvatar() });
  await until(wornAlone, 'the avatar');
  await page.reload();
  await until(wornAlone, 'the avatar again');
  assert.deepEqual((await pixels()).corner, [0, 255, 0, 255]);
});

test('the page gives the performer the avatar again', async () => {
  await page.goto(address); // the token is this tab's
  await until(() => page.evaluate(() => globalThis.styled.stage.performers.get('face.mia')?.avatar?.name === 'Mia v2.vrm'), 'the avatar');
});

test('without WebCodecs the stage is filmed, and its video plays to the end without a black frame', async () => {
  await page.goto('about:blank');
  const stage = await browser.newPage({ viewport: { width: 1280, height: 720 } }); // drawn as a browser draws
  stage.setDefaultTimeout(60000 * patience);
  stage.on('pageerror', (error) => errors.push(error.message));
  await stage.goto(`${address}/#token=${TOKEN}`);
  assert.ok(!(await stage.evaluate(() => 'VideoEncoder' in globalThis)), 'a page without TLS');
  const list = stage.getByLabel('Formats to save');
  await list.selectOption('video');
  assert.equal(await list.locator('option:checked').textContent(), 'Video of the stage, as drawn');
  await until(() => stage.evaluate(() => [...globalThis.styled.stage.performers.values()][0]?.roles.after.figure !== undefined), 'a body');
  const download = stage.waitForEvent('download');
  await stage.locator('button.record').click();
  const pictures = await stage.evaluate(() => globalThis.styled.stage.pictures);
  await until(() => stage.evaluate((n) => globalThis.styled.stage.pictures > n + 20, pictures), 'pictures');
  await stage.locator('button.record').click();
  const file = await download;
  assert.match(file.suggestedFilename(), /-video-[\d-]+\.webm$/);
  const base64 = readFileSync(await file.path()).toString('base64');
  await stage.close();
  // On a blank page, since the page's own policy permits only its own content.
  const blank = await browser.newPage();
  const played = await blank.evaluate(async (base64) => {
    const video = document.createElement('video');
    video.muted = true;
    video.src = URL.createObjectURL(new Blob([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))]));
    const bright = () => {
      const canvas = new OffscreenCanvas(video.videoWidth, video.videoHeight);
      canvas.getContext('2d').drawImage(video, 0, 0);
      const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      return data.filter((value, i) => i % 4 < 3 && value > 100).length;
    };
    const came = (event) =>
      new Promise((resolve, reject) => {
        video.addEventListener(event, resolve);
        video.addEventListener('error', () => reject(new Error('no video')));
      });
    const shown = [];
    const look = () => {
      shown.push(bright());
      video.requestVideoFrameCallback(look);
    };
    video.requestVideoFrameCallback(look);
    video.play();
    await came('ended');
    return { width: video.videoWidth, shown };
  }, base64);
  await blank.close();
  assert.ok(played.width > 200 && played.shown.length > 3 && Math.min(...played.shown) > 200, JSON.stringify(played));
});

test('without WebGL all panels and Panic remain, and both bodies are drawn as lines', async () => {
  poor = await launch(['--disable-3d-apis', '--host-resolver-rules=MAP far.test 127.0.0.1']);
  lines = await poor.newPage({ viewport: { width: 1280, height: 720 }, colorScheme: 'dark' });
  lines.setDefaultTimeout(60000 * patience);
  await drawSeldom(lines);
  for (const event of ['pageerror', 'console']) lines.on(event, (one) => (one.type?.() ?? 'error') === 'error' && !/401|WebSocket/.test(one.text?.()) && errors.push(one.message ?? one.text()));
  await lines.goto(address);
  await lines.locator('.banner input').fill(`${TOKEN}x`);
  await Promise.all([lines.waitForEvent('load'), lines.keyboard.press('Enter')]); // it asks again
  await lines.locator('.banner input').fill(TOKEN);
  await Promise.all([lines.waitForEvent('load'), lines.keyboard.press('Enter')]);
  await until(() => lines.evaluate(() => globalThis.styled?.app.live().length === 1 && globalThis.styled.app.list), 'the page with the typed token');
  assert.ok(!(await lines.locator('.banner').isVisible()) && (await lines.locator('.filter').isVisible()), 'no question any more; find is there');
  assert.equal(await lines.evaluate(() => document.createElement('canvas').getContext('webgl2')), null, 'there is no WebGL');
  // Pixels of the colours of the two bodies.
  const drawn = () => lines.evaluate(() => {
    const { canvas } = globalThis.styled.stage;
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    let before = 0, after = 0, sum = 0;
    for (let i = 0; i < data.length; i += 4) {
      before += data[i + 2] > data[i] + 20 && data[i + 2] > 120;
      after += data[i] > data[i + 2] + 80;
      sum = (Math.imul(sum, 31) + data[i]) | 0;
    }
    return { before, after, sum };
  });
  let first;
  await until(async () => (first = await drawn()).before > 2000 && first.after > 2000, 'two bodies');
  await until(async () => (await drawn()).sum !== first.sum, 'them to move');
  assert.deepEqual(await panelsOf(lines), panels);
  for (const [width, height] of [[1280, 720], [1920, 1080]]) {
    await lines.setViewportSize({ width, height });
    assert.deepEqual(await hiddenPanels(lines), [], `${width} x ${height} without a scroll`);
    await takePicture(lines, `${width}x${height}`);
  }
  await lines.setViewportSize({ width: 1280, height: 560 });
  assert.notDeepEqual(await hiddenPanels(lines), [], 'it would be found');
  await lines.setViewportSize({ width: 640, height: 360 });
  await lines.locator('[data-performer]').waitFor();
  assert.deepEqual(await lines.evaluate(() => [document.querySelector('[data-performer]'), document.querySelector('[data-style]'), document.querySelector('.stage')]
    .map((element) => element.getBoundingClientRect()).filter(({ top, bottom }) => top < 0 || bottom > innerHeight)), [], 'a phone on its side');
  await takePicture(lines, '640x360');
  await lines.setViewportSize({ width: 1280, height: 720 });
  await lines.locator('.panic').click();
  await until(async () => /all performers are in bypass/.test(await lines.locator('.toast').textContent()), 'panic');
  await takePicture(lines, 'without WebGL');
});

test('a browser that prefers light gets a light page, without a violation; the stage stays dark', async () => {
  const brightness = (of) => lines.evaluate((of) => getComputedStyle(document.querySelector(of)).backgroundColor.match(/\d+/g).slice(0, 3).map(Number), of);
  assert.ok((await brightness('.panel')).every((value) => value < 40));
  await lines.emulateMedia({ colorScheme: 'light', reducedMotion: 'reduce' });
  assert.ok((await brightness('.panel')).every((value) => value > 200));
  assert.ok((await brightness('main')).every((value) => value < 40));
  const inLight = await axeOf(lines);
  await lines.locator('[data-style]').nth(3).click();
  await until(async () => (await lines.locator('[data-style]').nth(3).getAttribute('aria-pressed')) === 'true', 'a chosen style');
  for (const [width, height] of [[1280, 720], [390, 844]]) {
    await lines.setViewportSize({ width, height });
    await takePicture(lines, `light ${width}`);
    assert.deepEqual(await inLight(), [], `${width} x ${height}`);
  }
});

test('nothing went wrong within', () => assert.deepEqual(errors, []));
