// VMC by another's OSC (osc-min), over UDP on loopback.
//   node vmc.mjs read PORT          prints each message that comes, "ADDRESS ,TYPES VALUE ...", floats
//                                   as their bits in hexadecimal
//   node vmc.mjs send PORT FILE HZ  sends such messages, bundled up to each empty line; half of them
//                                   in a bundle within
import dgram from 'node:dgram';
import fs from 'node:fs';
import { fromBuffer, toBuffer } from 'osc-min';

const [mode, port, file, rate] = process.argv.slice(2);
const socket = dgram.createSocket('udp4');
const view = new DataView(new ArrayBuffer(4));

function bitsOf(value) {
  view.setFloat32(0, value);
  return view.getUint32(0).toString(16).padStart(8, '0');
}
function floatOf(bits) {
  view.setUint32(0, parseInt(bits, 16));
  return view.getFloat32(0);
}

const kLetters = { string: 's', float: 'f', integer: 'i' };

function print(packet) {
  if (packet.oscType === 'bundle') return packet.elements.forEach(print);
  const types = packet.args.map(({ type }) => kLetters[type] ?? '?').join('');
  const values = packet.args.map(({ type, value }) => ` ${type === 'float' ? bitsOf(value) : value}`);
  fs.writeSync(1, `${packet.address} ,${types}${values.join('')}\n`);
}

function parse(line) {
  const [address, types, ...values] = line.split(' ');
  const args = values.map((value, i) => {
    if (types[i + 1] === 'f') return { type: 'float', value: floatOf(value) };
    if (types[i + 1] === 'i') return { type: 'integer', value: Number(value) };
    return { type: 'string', value };
  });
  return { address, args };
}

function bundle(text) {
  const messages = text.split('\n').map(parse);
  const half = messages.length >> 1;
  const timetag = new Date();
  const inner = { timetag, elements: messages.slice(half) };
  return toBuffer({ timetag, elements: [...messages.slice(0, half), inner] });
}

if (mode === 'read') {
  socket.on('message', (bytes) => print(fromBuffer(bytes)));
  socket.bind(Number(port), '127.0.0.1');
} else {
  const frames = fs.readFileSync(file, 'utf8').trimEnd().split('\n\n');
  const start = performance.now();
  for (const [i, frame] of frames.entries()) {
    const due = start + (i * 1000) / Number(rate);
    await new Promise((done) => setTimeout(done, Math.max(0, due - performance.now())));
    await new Promise((done) => socket.send(bundle(frame), Number(port), '127.0.0.1', done));
  }
  socket.close();
}
