// Makes the pictures and the film's frames of README.md and clients/guides, in a real browser in front of the real
// programs. tests/pictures.sh runs it.
//   STYLED_BIN=build/release/bin CHROMIUM=/usr/bin/chromium node pictures.mjs FOLDER
// FOLDER gets vtuber.png, stage.png, animator.png, and film/SECONDS.jpg, each named by its time.
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import path from 'node:path';

import { makeDoll } from './doll.mjs';
import { bin, drop, endAll, file, launch, pause, start, startAll, startWeb, until } from './house.mjs';

const FILM_S = 6;
const [folder] = process.argv.slice(2);
const to = (name) => path.join(folder, name);
mkdirSync(to('film'), { recursive: true });

const { udp } = await startAll(`[presets]
tired_elder = { elderly = 0.7, exhausted = 0.3 }
[[cue]]
name = "entrance"
style = "proud"
[[cue]]
name = "act-2"
style = "elderly"
[[cue]]
name = "chase"
style = "zombie"
`);
const { address } = await startWeb('127.0.0.1:0');
const browser = await launch();

async function open(size) {
  const page = await browser.newPage({ viewport: size, colorScheme: 'dark' });
  await page.goto(address);
  await until(() => page.evaluate(() => globalThis.styled.app.live().length > 0 && globalThis.styled.app.list !== undefined), 'a performer');
  return page;
}
const wear = async (page, style, seconds = 4) => {
  await page.locator(`[data-style="${style}"]`).click();
  await pause(1000 * seconds);
};
const select = (page, name) => page.evaluate((name) => globalThis.styled.app.select(name), name);

const walk = ['--rate', '60', '--script', 'walk:6,turn-left:1'];
const sim = start('stylesim', '--to', `udp://${udp}`, ...walk);
const page = await open({ width: 1280, height: 720 });
await pause(8000); // their neutral is learned
await drop(page, ['Doll.vrm', makeDoll()]);
await until(() => page.evaluate(() => globalThis.styled.stage.performers.get('rig.sim')?.avatar?.ready), 'the avatar');

// The film: as captured, then three styles.
const session = await page.context().newCDPSession(page);
let begun = 0;
session.on('Page.screencastFrame', ({ data, metadata, sessionId }) => {
  begun ||= metadata.timestamp;
  writeFileSync(to(`film/${(metadata.timestamp - begun).toFixed(3).padStart(7, '0')}.jpg`), Buffer.from(data, 'base64'));
  void session.send('Page.screencastFrameAck', { sessionId });
});
await page.keyboard.press('Escape');
await pause(6000); // the message of Panic has gone
await session.send('Page.startScreencast', { format: 'jpeg', quality: 92, maxWidth: 1280, maxHeight: 720 });
await pause(1300);
for (const style of ['elderly', 'zombie', 'giant']) await wear(page, style, (FILM_S - 1.3) / 3);
await session.send('Page.stopScreencast');
await page.screenshot({ path: to('vtuber.png') });

// A stage: two performers, cues, and the way of the frames.
sim.kill('SIGKILL');
for (const name of ['anna', 'ben']) start('stylesim', '--to', `udp://${udp}`, '--performer', name, ...walk);
await until(() => page.evaluate(() => globalThis.styled.app.live().length === 2), 'two performers');
await select(page, 'rig.anna');
await page.getByText('act-2').first().click();
await pause(9000);
await page.locator('[data-why]').click();
await pause(2500);
await page.screenshot({ path: to('stage.png') });

// An animator: the sheet of a clip in some styles.
execFileSync(path.join(bin, 'stylesim'), ['--write', file('walk.bvh'), '--seconds', '6', '--rate', '30', '--script', 'walk:6']);
execFileSync(path.join(bin, 'stylize'), ['--style', 'elderly,angry,giant,not-confident', '--sheet', path.resolve(to('sheet.html')), 'walk.bvh'], { cwd: file('') });
const sheet = await browser.newPage({ viewport: { width: 980, height: 450 }, colorScheme: 'light' });
await sheet.goto(`file://${path.resolve(to('sheet.html'))}`);
await pause(1500);
await sheet.screenshot({ path: to('animator.png') });
await endAll(browser);
process.exit(0);
