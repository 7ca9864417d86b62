// A fake daemon behind the fake styleweb, for tests of a page: performers who walk, looks that can be set, cues.
// Poses are not styled: the tests check the page, never the daemon.
import { create, toBinary } from '@bufbuild/protobuf';
import { BodySchema, Code, FrameSchema, LookSchema, Output, StatsSchema } from 'styled-client';

import { Gateway } from './gateway.mjs';
import { HUMANOID } from './humanoid.mjs';

const JOINTS = [
  ...HUMANOID,
  ['leftEye', 4, 0.03, 0.06, 0.08], ['rightEye', 4, -0.03, 0.06, 0.08],
];
const RATE_HZ = 20; // a rate that a busy machine can draw, since nothing is dropped in between as
                    // behind the real gateway
const about = (axis, angle) => [0, 1, 2].map((k) => (k === axis ? Math.sin(angle / 2) : 0)).concat(Math.cos(angle / 2));

/** The body of a performer; `output`: rig or canonical. */
export const humanoid = (performer, output) => create(BodySchema, {
  performer, output, hash: output === Output.CANONICAL ? 8n : 7n, metresPerUnit: 1, names: JOINTS.map(([name]) => name),
  parents: JOINTS.map(([, parent]) => parent), offsets: JOINTS.flatMap(([, , ...offset]) => offset),
});

// Frame `i` of a walk.
function walk(performer, output, i, fields) {
  const t = i / RATE_HZ, swing = Math.sin(5 * t);
  const turns = { leftUpperArm: about(2, -1.2), rightUpperArm: about(2, 1.2), leftUpperLeg: about(0, 0.5 * swing), rightUpperLeg: about(0, -0.5 * swing),
    leftLowerLeg: about(0, 0.4 - 0.4 * swing), rightLowerLeg: about(0, 0.4 + 0.4 * swing), leftLowerArm: about(1, -0.4 - 0.3 * swing),
    rightLowerArm: about(1, 0.4 - 0.3 * swing), head: about(1, 0.4 * Math.sin(t)), leftEye: about(1, 0.1), rightEye: about(1, 0.1) };
  return create(FrameSchema, {
    performer, output, epoch: 1n, sequence: BigInt(i), bodyHash: output === Output.CANONICAL ? 8n : 7n, sourceSequence: BigInt(i),
    sourceTimeNs: BigInt(Math.round((i * 1e9) / RATE_HZ)), receiveTimeNs: BigInt(Math.round((i * 1e9) / RATE_HZ)),
    rootPosition: [0, 0.93 + 0.02 * Math.cos(10 * t), 0.9 * t], rotations: JOINTS.flatMap(([name]) => turns[name] ?? [0, 0, 0, 1]), ...fields,
  });
}

const newLook = () => create(LookSchema, {
  mix: [], strength: 1, transitionMs: 100, absolute: false, parts: [0], inputStyle: '', preset: '', root: 0, vary: 0, varyEach: false, varyAmount: 1, driftS: 0, mirror: false, idle: 0,
});

export class Daemon {
  live = true;
  frame = 0;
  sources = [{ name: 'rig', type: 'udp', listen: 'udp://127.0.0.1:7000', received: 100n }];
  looks = new Map();
  pinned = new Set();
  layers = new Map(); // performer -> LayerStats
  list = { styles: ['neutral', 'active', 'angry', 'elderly', 'youthful'].map((name) => ({ name, neutral: name === 'neutral' })), presets: [], cues: [] };
  likes = []; // the requests of Like
  hold = undefined; // a promise that replies to Like wait for
  previews = []; // the styles whose preview was requested
  cues = new Map(); // name -> Look's fields, for all who are not pinned
  fields = () => ({}); // frame's number -> what else it has

  /** `page`: folder of the built page. */
  static async start(performers, page) {
    const daemon = new Daemon();
    const gateway = daemon.gateway = await Gateway.start();
    gateway.page = page;
    for (const performer of performers) daemon.looks.set(performer, newLook());
    gateway.answer = (request) => daemon.#answer(request);
    gateway.onJoin = () => setTimeout(() => gateway.notice({ styleweb: 'fake', watchOnly: false, daemon: { up: true, reason: '' } }), 10);
    gateway.onSubscribe = () => {
      clearTimeout(daemon.telling);
      daemon.telling = setTimeout(() => daemon.#introduce(), 10);
    };
    daemon.timers = [setInterval(() => daemon.tell(), 1000), setInterval(() => daemon.#walkOn(), 1000 / RATE_HZ)];
    return daemon;
  }

  stop() {
    this.timers.forEach(clearInterval);
    return this.gateway.stop();
  }

  /** Another user sets a look. */
  set(performer, fields) {
    const look = this.looks.get(performer);
    const { clear, mix, ...others } = fields;
    if (clear || mix?.length > 0) Object.assign(look, { mix: create(LookSchema, { mix: mix ?? [] }).mix, preset: '' });
    for (const [name, value] of Object.entries(others)) if (value !== undefined && name !== '$typeName' && !(name === 'parts' && value.length === 0)) look[name] = value;
  }

  #introduce() {
    for (const performer of this.looks.keys()) {
      for (const output of [Output.RIG, Output.CANONICAL]) this.gateway.publish(`body/${performer}/`, toBinary(BodySchema, humanoid(performer, output)));
    }
    this.tell();
  }

  /** Publishes statistics. */
  tell() {
    this.gateway.publish('stats/', toBinary(StatsSchema, this.#stats()));
  }

  #stats() {
    return create(StatsSchema, {
      epoch: 1n, sources: this.sources, performers: [...this.looks].map(([performer, look]) => ({
        performer, look, live: this.live, rateHz: this.live ? RATE_HZ : 0, pinned: this.pinned.has(performer), layers: this.layers.get(performer) ?? [] })),
    });
  }

  #walkOn() {
    if (!this.live) return;
    const i = ++this.frame;
    for (const performer of this.looks.keys()) {
      for (const [topic, output] of [[`source/${performer}/`, Output.RIG], [`styled/${performer}/rig/`, Output.RIG], [`styled/${performer}/canonical/`, Output.CANONICAL]]) {
        if (!this.gateway.topics.has(topic)) continue;
        this.gateway.publish(topic, toBinary(FrameSchema, walk(performer, output, i, { styles: this.looks.get(performer).mix, ...this.fields(i) })));
      }
    }
  }

  // A style by hand, or of any example.
  async #like(performer, like) {
    this.likes.push({ performer, ...like });
    await this.hold;
    const name = like.name || `by-hand-${performer.replace('.', '-')}`;
    const { styles } = this.list, former = styles.find((style) => style.name === name);
    const { from = '', sliders = {} } = like.design ?? {};
    const made = { name, made: true, source: from || 'by hand', sliders: { ...former?.sliders, ...sliders } };
    this.list.styles = former ? styles.map((style) => (style === former ? made : style)) : [...styles, made];
    if (this.pinned.has(performer)) return { code: Code.PINNED, reason: `like: ${performer} is pinned` };
    if (performer) this.set(performer, { mix: [{ style: name, weight: 1 }] });
    return { like: { name, found: this.found?.found, weak: this.found?.weak, nearest: 'elderly', distance: 2 } };
  }

  #answer({ performer, command: { case: what, value } }) {
    const all = [...this.looks.keys()];
    const whom = performer === '*' ? all.filter((one) => !this.pinned.has(one)) : [performer];
    if (what === 'list') return { list: this.list };
    if (what === 'status') return { status: { version: 'fake', epoch: 1n, weights: 'none.safetensors', stats: this.#stats() } };
    if (what === 'like') return this.#like(performer, value);
    if (what === 'importStyle') return { like: { name: value.name } };
    if (what === 'exportStyle') return { styleFile: { name: value.name, file: new TextEncoder().encode(JSON.stringify({ name: value.name })) } };
    if (what === 'removeStyle') this.list.styles = this.list.styles.filter(({ name }) => name !== value.name);
    else if (what === 'preview' && this.list.sliders) {
      this.previews.push(value.style);
      return { preview: { rateHz: 15, joints: 21, positionsMm: new Array(2 * 63).fill(0).map((_, i) => 80 * (i % 21)) } };
    } else if (what === 'pin') for (const one of performer === '*' ? all : whom) this.pinned[value.pinned ? 'add' : 'delete'](one);
    else if (what === 'panic') for (const one of all) this.set(one, { clear: true });
    else if (what === 'set') {
      if (performer !== '*' && this.pinned.has(performer)) return { code: Code.PINNED, reason: `${performer} is pinned` };
      for (const one of whom) this.set(one, value);
    } else if (what === 'cue') {
      const fields = this.cues.get(value.name);
      if (!fields) return { code: Code.UNKNOWN_CUE, reason: `no cue "${value.name}"` };
      for (const one of all) if (!this.pinned.has(one)) this.set(one, fields);
    } else return { code: Code.UNKNOWN_COMMAND, reason: `the fake daemon knows no ${what}` };
    return {};
  }
}
