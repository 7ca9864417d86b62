// SlimeVR's trackers by another's program: the emulation and the packets of its own npm packages.
//   node trackers.mjs packets HEX ...   prints one packet of each type that trackers send, and one answer
//                                       of a server, by name and as hexadecimal bytes; then how each HEX,
//                                       an answer of ours, is understood
//   node trackers.mjs play PORT FILE HZ INTRUDER
// plays FILE to 127.0.0.1:PORT: lines "TICK BOARD X Y Z W" (a rotation of the board's one sensor) and
// "TICK BOARD ACTION" (its button), by tick. Boards have MACs 02:53:56:00:00:01, ... With INTRUDER 1 a
// further board with the first one's MAC seeks the server while they play. Prints what each heard:
// "BOARD PINGS HEARTBEATS BUNDLES ERRORS", and the intruder's state.
import fs from 'node:fs';
import { MACAddress, Quaternion, Vector } from '@slimevr/common';
import * as firmware from '@slimevr/firmware-protocol';
import { EmulatedTracker } from '@slimevr/tracker-emulation';

const sleep = (ms) => new Promise((done) => setTimeout(done, Math.max(0, ms)));
const macOf = (board) => new MACAddress([0x02, 0x53, 0x56, 0, 0, board + 1]);

function packets() {
  const flags = new firmware.FirmwareFeatureFlags(new Map([['ROTATION_DATA', true]]));
  const number = 0x0102030405060708n;
  const all = [
    new firmware.ServerBoundHandshakePacket(4, 13, 2, 13, '0.7.2', macOf(0x1c)),
    new firmware.ServerBoundHeartbeatPacket(),
    new firmware.ServerBoundRotationPacket(new Quaternion(0.5, -0.5, 0.5, -0.5)),
    new firmware.ServerBoundRotationDataPacket(3, 1, new Quaternion(0.6, 0, -0.8, 0), 7),
    new firmware.ServerBoundAccelPacket(5, new Vector(0.25, -9.75, 2)),
    new firmware.ServerBoundPongPacket(-559038737),
    new firmware.ServerBoundBatteryLevelPacket(3.75, 50),
    new firmware.ServerBoundTapPacket(1, 2),
    new firmware.ServerBoundErrorPacket(2, 9),
    new firmware.ServerBoundSensorInfoPacket(4, 1, 13),
    new firmware.ServerBoundMagnetometerAccuracyPacket(6, 0.5),
    new firmware.ServerBoundSignalStrengthPacket(255, -61),
    new firmware.ServerBoundTemperaturePacket(1, 36.5),
    new firmware.ServerBoundUserActionPacket(3),
    new firmware.ServerBoundFeatureFlagsPacket(flags),
    new firmware.DeviceBoundSensorInfoPacket(3, 1)  // their parser reads this one from its type on
  ];
  for (const packet of all) {
    console.log(`${packet.constructor.name} ${packet.encode(number).toString('hex')}`);
  }
  for (const hex of process.argv.slice(3)) {
    const [, packet] = firmware.parse(Buffer.from(hex, 'hex'), true);
    console.log(String(packet));
  }
}

function makeTracker(board, port) {
  const tracker = new EmulatedTracker(
    macOf(board), '0.7.2', new firmware.FirmwareFeatureFlags(new Map()), firmware.BoardType.UNKNOWN,
    firmware.MCUType.UNKNOWN, '127.0.0.1', port);
  const heard = { pings: 0, heartbeats: 0, bundles: 0, errors: 0 };
  tracker.on('incoming-packet', (packet) => {
    if (packet.type === firmware.DeviceBoundPingPacket.type) ++heard.pings;
    if (packet.type === firmware.DeviceBoundHeartbeatPacket.type) ++heard.heartbeats;
  });
  tracker.on('server-feature-flags', (flags) => {
    if (flags.has('PROTOCOL_BUNDLE_SUPPORT')) ++heard.bundles;
  });
  for (const event of ['error', 'unknown-incoming-packet', 'disconnected-from-server']) {
    tracker.on(event, () => ++heard.errors);
  }
  return { tracker, heard };
}

async function play(port, file, rate, withIntruder) {
  const lines = fs.readFileSync(file, 'utf8').trimEnd().split('\n').map((line) => line.split(' ').map(Number));
  const boards = [];
  for (let k = 0; k <= Math.max(...lines.map(([, board]) => board)); ++k) boards.push(makeTracker(k, port));
  await Promise.all(boards.map(async ({ tracker }) => {
    await tracker.addSensor(firmware.SensorType.UNKNOWN, firmware.SensorStatus.OK);
    const connected = new Promise((done) => tracker.on('connected-to-server', done));
    await tracker.init();
    await connected;
  }));
  const intruder = makeTracker(0, port);
  if (withIntruder) await intruder.tracker.init();
  const start = performance.now();
  for (const [tick, board, ...values] of lines) {
    await sleep(start + (tick * 1000) / rate - performance.now());
    const { tracker } = boards[board];
    if (values.length === 1) await tracker.sendUserAction(values[0]);
    else await tracker.sensors[0].sendRotation(1, Quaternion.from(values), 0);
  }
  for (const [k, { heard }] of boards.entries()) {
    console.log(`${k} ${heard.pings} ${heard.heartbeats} ${heard.bundles} ${heard.errors}`);
  }
  console.log(intruder.tracker.state.status);
  process.exit(0);
}

const [mode, ...rest] = process.argv.slice(2);
if (mode === 'packets') packets();
else await play(Number(rest[0]), rest[1], Number(rest[2]), rest[3] === '1');
