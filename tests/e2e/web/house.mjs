// Shared by the tests of the page: daemon, gateway, simulator and browser, in a folder of their own.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { chromium } from 'playwright-core';

export const bin = process.env.STYLED_BIN;
const folder = mkdtempSync(path.join(os.tmpdir(), 'styled-page-'));
export const file = (name) => path.join(folder, name);
export const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
/** Factor of all waits: for a machine that is busy with something else. */
export const patience = Number(process.env.PATIENCE ?? 1);
const children = new Set();

export async function until(condition, what, seconds = 60) {
  for (const end = Date.now() + 1000 * seconds * patience; Date.now() < end; await pause(50)) {
    if (await condition()) return;
  }
  throw new Error(`waited in vain for ${what}`);
}

export function start(program, ...options) {
  const child = spawn(path.join(bin, program), options, { stdio: ['ignore', 'ignore', 'inherit'] });
  children.add(child);
  child.ended = new Promise((resolve) => child.once('exit', resolve));
  return child;
}

export async function startDaemon() {
  rmSync(file('ready.json'), { force: true });
  const daemon = start('styled', '--config', file('styled.toml'), '--ready-file', file('ready.json'),
    '--set', 'log.level=warn', '--set', 'realtime.lock_memory=false');
  await until(() => existsSync(file('ready.json')), 'the daemon');
  return daemon;
}

/** The gateway and its address. */
export async function startWeb(listen, ...options) {
  rmSync(file('web.json'), { force: true });
  const web = start('styleweb', '--listen', listen, '--publish', `ipc://${file('publish')}`,
    '--control', `ipc://${file('control')}`, '--ready-file', file('web.json'), ...options);
  await until(() => existsSync(file('web.json')), 'styleweb');
  return { web, address: JSON.parse(readFileSync(file('web.json'), 'utf8')).listen };
}

/**
 * Starts the daemon with one source and these further sections, and returns it with the address of its
 * source. A restart uses the port of the first start, so that the simulator finds the daemon again.
 */
export async function startAll(sections) {
  const config = (udp) => writeFileSync(file('styled.toml'), `[[source]]
name = "rig"
type = "udp"
listen = "${udp}"
[publish]
address = "ipc://${file('publish')}"
[control]
address = "ipc://${file('control')}"
${sections}`);
  config('127.0.0.1:0');
  const daemon = await startDaemon();
  const udp = JSON.parse(readFileSync(file('ready.json'), 'utf8')).sources[0].listen;
  config(udp);
  return { daemon, udp };
}

export const launch = (args = []) =>
  chromium.launch({
    executablePath: process.env.CHROMIUM,
    args: [...args, '--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  });

/** Before a page is opened: its stage is drawn seldom, every pace_ms of the page. */
export const drawSeldom = (page, pace_ms = 400) =>
  page.addInitScript((pace_ms) => {
    globalThis.pace_ms = pace_ms;
    globalThis.requestAnimationFrame = (call) => setTimeout(() => call(performance.now()), globalThis.pace_ms);
    globalThis.cancelAnimationFrame = (id) => clearTimeout(id);
  }, pace_ms);

/** Drops files on the page: pairs of name and bytes. */
export const drop = (page, ...files) =>
  page.evaluate((files) => {
    const transfer = new DataTransfer();
    for (const [name, base64] of files) {
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    }
    dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, cancelable: true, bubbles: true }));
  }, files.map(([name, bytes]) => [name, bytes.toString('base64')]));

// Violations of WCAG 2.2, A and AA, as axe-core finds them.
const axe = readFileSync(new URL('node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');
export async function axeOf(page) {
  if (!(await page.evaluate(() => 'axe' in globalThis))) await page.evaluate(axe);
  return (within = 'body') => page.evaluate(async (within) => {
    const { violations } = await globalThis.axe.run(within, {
      runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'], resultTypes: ['violations'] });
    return violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target}: ${failureSummary}`));
  }, within);
}

export async function takePicture(page, name) {
  if (process.env.SCREENSHOTS) await page.screenshot({ path: path.join(process.env.SCREENSHOTS, `${name}.png`) });
}

export async function endAll(browser) {
  await browser?.close();
  for (const child of children) child.kill('SIGKILL');
  rmSync(folder, { recursive: true, force: true });
}
