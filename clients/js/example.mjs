// Sets a style, then prints the position of each performer's head, ten times per second.
import { StyledClient, worldTransforms } from 'styled-client';

const USAGE = 'usage: node example.mjs [URL [STYLE [FRAMES]]]';
const [url = 'http://127.0.0.1:7080', style = 'elderly', atMost = 'Infinity', ...more] = process.argv.slice(2);
const enough = Number(atMost);
if (url === '--help' || url === '-h') {
  console.log(USAGE);
  process.exit();
}
let client;
try {
  if (!(enough > 0) || more.length) throw new TypeError(`found "${[atMost, ...more].join(' ')}", expected a number above 0`);
  client = new StyledClient({ url });
} catch (error) {
  console.error(`${error.message}\n${USAGE}`);
  process.exit(2);
}

client.on('link', (state) => {
  if (state.reason) console.error(`${client.linkState.kind}: ${state.reason}`);
});
client.on('daemon', async (daemon) => {
  if (!daemon.up) return console.error(daemon.reason);
  try {
    await client.setStyle('*', style, 0.8);
  } catch (error) {
    console.error(`style not set: ${error.message}`);
  }
});

const performers = new Set();
let frames = 0, missed = 0;
client.on('body', ({ performer }) => {
  if (performers.has(performer)) return;
  performers.add(performer);
  client.subscribeLatest(performer, 'canonical');
});
client.subscribeBodies();

setInterval(() => {
  for (const performer of performers) {
    const update = client.latest(performer, 'canonical');
    if (!update?.body) continue;
    frames += 1 + update.skipped; // includes those that arrived between two calls
    missed += update.missed;
    const head = 3 * update.body.names.indexOf('head');
    const at = worldTransforms(update.body, update.frame).positions.subarray(head, head + 3);
    console.log(performer, ...[...at].map((metres) => metres.toFixed(2)), 'm');
  }
  if (frames < enough) return;
  console.error(`${frames} frames, ${missed} missed`);
  process.exit();
}, 100);
