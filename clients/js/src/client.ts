import {
  create,
  fromBinary,
  toBinary,
  type DescMessage,
  type MessageInitShape,
} from '@bufbuild/protobuf';

import { NoAnswerError, RefusedError } from './errors.js';
import { BodySchema, Output, type Body } from './gen/proto/styled/v1/body_pb.js';
import {
  Calibrate_Pose,
  Calibrate_Sensors,
  Code,
  ReplySchema,
  RequestSchema,
  type Applied,
  type CalibrateReply,
  type ListReply,
  type Reply,
  type StatusReply,
} from './gen/proto/styled/v1/control_pb.js';
import { FrameSchema, type Frame } from './gen/proto/styled/v1/frame_pb.js';
import { type LookSchema } from './gen/proto/styled/v1/look_pb.js';
import { StatsSchema, type Stats } from './gen/proto/styled/v1/stats_pb.js';
import { checkBody, checkFrame } from './kinematics.js';
import { Link, type LinkState } from './link.js';
import { checkPerformer, checkPerformers, frameTopic, parseTopic, type Stream } from './topics.js';

const MAX_BODIES = 64; // kept of each performer
const UNKNOWN_MS = 2000; // the daemon answers a subscription with bodies at once

/** How the daemon is, as the gateway sees it. */
export interface DaemonState {
  up: boolean;
  reason: string;
}

/** One frame, with what belongs to it. */
export interface Update {
  performer: string;
  stream: Stream;
  frame: Frame;
  /** Its skeleton, checked; undefined while it has not arrived. */
  body: Body | undefined;
  /** Frames of this stream just before it that did not arrive: lost, or passed over on the way to us
   * because we did not read. */
  missed: number;
  /** Older frames that arrived and that this one superseded; of `latest` only. */
  skipped: number;
  /** The daemon was restarted since the stream's last frame. */
  newEpoch: boolean;
}

export interface ClientEvents {
  link(state: LinkState): void;
  daemon(state: DaemonState): void;
  frame(update: Update): void;
  body(body: Body): void;
  stats(stats: Stats): void;
  /** What the gateway did not understand or refused, and once for each name subscribed to that the
   * daemon sent no body of: whoever bears it may still come. `unknown` is that name. */
  complaint(text: string, unknown?: string): void;
}

export interface ClientOptions {
  /** Where styleweb is: "http://127.0.0.1:7080", or its WebSocket "ws://127.0.0.1:7080/ws". */
  url: string;
  token?: string;
  /** Of one control request. */
  timeout_ms?: number;
}

type Mode = 'everyFrame' | 'latest';

// How far one kind of subscriber has come: both of a stream may be there, and what the one was handed
// is still to come for the other.
class Reader {
  users = 0;
  sinceLast = 0; // arrived since the last one that was handed on
  epoch = 0n;
  sequence = 0n;
  started = false;
}

interface StreamState {
  performer: string;
  stream: Stream;
  everyFrame: Reader; // want each frame parsed as it comes
  latest: Reader; // want the newest alone
  raw: Uint8Array | undefined; // the newest, not parsed yet
  frames: number; // arrived
}

interface Pending {
  resolve(reply: Reply): void;
  reject(error: Error): void;
  timer: ReturnType<typeof setTimeout>;
}

/** How a performer stands while it is calibrated, and what of the rig is. */
export interface CalibrateOptions {
  /** 't': arms sideways, palms down (default); 'n': arms hanging, palms at the thighs. */
  pose?: keyof typeof POSES;
  /** Of rigs without a skeleton: how sensors are worn and heading ('full', default), heading alone
   * ('yaw'), or 'mounting' in the second pose of the rig's own habit. */
  sensors?: keyof typeof SENSORS;
  /** Forget the calibration instead. */
  clear?: boolean;
}

const POSES = { t: Calibrate_Pose.T, n: Calibrate_Pose.N };
const SENSORS = {
  full: Calibrate_Sensors.FULL,
  yaw: Calibrate_Sensors.YAW,
  mounting: Calibrate_Sensors.MOUNTING,
};

// The number that a word stands for.
function wordOf<T extends Record<string, number>>(words: T, word: keyof T & string, what: string): T[keyof T & string] {
  if (!Object.hasOwn(words, word)) {
    throw new TypeError(`found "${word}" as ${what}, expected ${Object.keys(words).join(', ')}`);
  }
  return words[word];
}

export type SetInit = MessageInitShape<typeof LookSchema>;
type RequestInit = MessageInitShape<typeof RequestSchema>;

function socketUrl(options: ClientOptions): string {
  let url: URL | undefined;
  try {
    url = new URL(options.url);
  } catch {
    // said below
  }
  if (!url || !/^(http|ws)s?:$/.test(url.protocol)) {
    throw new TypeError(
      `found "${options.url}" as address of styleweb, expected ws://, wss://, http:// or https:// ` +
        'and its host, as in http://127.0.0.1:7080',
    );
  }
  if (url.protocol === 'http:' || url.protocol === 'https:') {
    url.protocol = url.protocol === 'http:' ? 'ws:' : 'wss:';
    url.pathname = url.pathname.replace(/\/?$/, '/ws');
  }
  if (options.token) url.searchParams.set('token', options.token);
  return url.href;
}

/**
 * A subscriber and control client of a styled daemon, through styleweb. Connects in the background
 * and again by itself; what was subscribed to stays so. Every-frame streams call back in order, with
 * gaps counted; latest-wins streams are asked (`latest`) by a renderer when it draws, and only what it
 * draws is parsed.
 */
export class StyledClient {
  private readonly link: Link;
  private readonly streams = new Map<string, StreamState>();
  private readonly plain = new Map<string, number>(); // other topics, counted
  private readonly bodies = new Map<string, Body[]>();
  private readonly listeners = new Map<keyof ClientEvents, Set<(...args: never[]) => void>>();
  private readonly pending = new Map<bigint, Pending>();
  private readonly awaited = new Map<string, ReturnType<typeof setTimeout>>(); // performers
  private readonly timeout_ms: number;
  private nextId = 1n;
  private linkState_: LinkState = { kind: 'connecting', reason: '' };
  private daemonState_: DaemonState = { up: false, reason: 'not connected yet' };
  private watchOnly_ = false;

  constructor(options: ClientOptions) {
    this.timeout_ms = options.timeout_ms ?? 3000;
    this.link = new Link(socketUrl(options), {
      state: (state) => this.onLink(state),
      text: (text) => this.onNotice(text),
      binary: (bytes) => this.onBinary(bytes),
    });
  }

  close(): void {
    for (const performer of [...this.awaited.keys()]) this.unawait(performer);
    this.link.close();
  }

  get linkState(): LinkState {
    return this.linkState_;
  }
  get daemonState(): DaemonState {
    return this.daemonState_;
  }
  /** The gateway lets nobody change anything. */
  get watchOnly(): boolean {
    return this.watchOnly_;
  }

  /** Returns a function that takes the listener away again. */
  on<K extends keyof ClientEvents>(event: K, listener: ClientEvents[K]): () => void {
    const set = this.listeners.get(event) ?? new Set();
    this.listeners.set(event, set);
    set.add(listener as (...args: never[]) => void);
    return () => set.delete(listener as (...args: never[]) => void);
  }

  // ---- subscribing. Each returns a function that ends it.

  /** Every frame, in order, as "frame" events. */
  subscribe(performer: string, stream: Stream = 'rig'): () => void {
    return this.addStream(performer, stream, 'everyFrame');
  }

  /** The newest frame, whenever `latest` asks. */
  subscribeLatest(performer: string, stream: Stream = 'rig'): () => void {
    return this.addStream(performer, stream, 'latest');
  }

  /** Statistics once a second, as "stats" events. */
  subscribeStats(): () => void {
    return this.addPlain('stats/');
  }

  /** Everyone's bodies, those of performers who come later too, as "body" events. */
  subscribeBodies(): () => void {
    return this.addPlain('body/');
  }

  /**
   * The newest frame of a stream of subscribeLatest that was not returned before; undefined where
   * there is none.
   */
  latest(performer: string, stream: Stream = 'rig'): Update | undefined {
    const state = this.streams.get(frameTopic(performer, stream));
    if (!state?.raw) return undefined;
    const raw = state.raw;
    state.raw = undefined;
    return this.accept(state, state.latest, raw);
  }

  /** Frames of a stream that have arrived, parsed or not. */
  arrived(performer: string, stream: Stream = 'rig'): number {
    return this.streams.get(frameTopic(performer, stream))?.frames ?? 0;
  }

  /** The performer's newest body of that kind. */
  body(performer: string, output: Output.RIG | Output.CANONICAL): Body | undefined {
    return this.bodies.get(performer)?.filter((body) => body.output === output).at(-1);
  }

  // ---- control. Each rejects with RefusedError or NoAnswerError; with TypeError, and nothing is sent,
  // where an argument cannot be meant. `performer` is SOURCE.NAME or "*", all.

  async list(): Promise<ListReply> {
    return (await this.ask({ command: { case: 'list', value: {} } })).list!;
  }
  async status(): Promise<StatusReply> {
    return (await this.ask({ command: { case: 'status', value: {} } })).status!;
  }
  /** Changes what is present in `change`. */
  set(performer: string, change: SetInit): Promise<Applied[]> {
    return this.change(performer, { case: 'set', value: change });
  }
  setStyle(performer: string, style: string, strength = 1): Promise<Applied[]> {
    return this.set(performer, { mix: [{ style, weight: 1 }], strength });
  }
  clear(performer: string): Promise<Applied[]> {
    return this.set(performer, { clear: true });
  }
  preset(performer: string, name: string, transitionMs?: number): Promise<Applied[]> {
    const value = { name, ...(transitionMs === undefined ? {} : { transitionMs }) };
    return this.change(performer, { case: 'preset', value });
  }
  pin(performer: string, pinned: boolean): Promise<Applied[]> {
    return this.change(performer, { case: 'pin', value: { pinned } });
  }
  reset(performer: string): Promise<Applied[]> {
    return this.change(performer, { case: 'reset', value: {} });
  }
  /** The performer, one, stands in this pose at this moment. */
  async calibrate(performer: string, options: CalibrateOptions = {}): Promise<CalibrateReply> {
    checkPerformer(performer);
    const { pose = 't', sensors = 'full', clear = false } = options;
    const value = { pose: wordOf(POSES, pose, 'pose'), sensors: wordOf(SENSORS, sensors, 'sensors'), clear };
    return (await this.ask({ performer, command: { case: 'calibrate', value } })).calibrate!;
  }
  /** Fires the cues of that name, of the daemon's configuration. */
  cue(name: string): Promise<Applied[]> {
    return this.change('*', { case: 'cue', value: { name } });
  }
  /** Everyone to bypass, pinned or not. */
  async panic(): Promise<Applied[]> {
    return (await this.ask({ command: { case: 'panic', value: {} } })).applied;
  }

  private async change(performer: string, command: RequestInit['command']): Promise<Applied[]> {
    checkPerformers(performer);
    return (await this.ask({ performer, command })).applied;
  }

  /** Any request, unchecked; its id is ours. */
  ask(request: RequestInit): Promise<Reply> {
    const id = this.nextId++;
    return new Promise((resolve, reject) => {
      const bytes = toBinary(RequestSchema, create(RequestSchema, { ...request, id }));
      if (!this.link.send(bytes)) {
        reject(new NoAnswerError('not connected to the gateway', false));
        return;
      }
      const timer = setTimeout(() => {
        this.settle(id)?.reject(new NoAnswerError(`no answer within ${this.timeout_ms} ms`));
      }, this.timeout_ms);
      this.pending.set(id, { resolve, reject, timer });
    });
  }

  // ---- within

  private settle(id: bigint): Pending | undefined {
    const pending = this.pending.get(id);
    if (pending) clearTimeout(pending.timer);
    this.pending.delete(id);
    return pending;
  }

  private emit<K extends keyof ClientEvents>(event: K, ...args: Parameters<ClientEvents[K]>): void {
    for (const listener of this.listeners.get(event) ?? []) {
      (listener as unknown as (...args: Parameters<ClientEvents[K]>) => void)(...args);
    }
  }

  private topics(add: boolean, topics: string[]): void {
    if (topics.length > 0) {
      this.link.send(JSON.stringify({ [add ? 'subscribe' : 'unsubscribe']: topics }));
    }
  }

  private addPlain(topic: string): () => void {
    const count = this.plain.get(topic) ?? 0;
    this.plain.set(topic, count + 1);
    if (count === 0) this.topics(true, [topic]);
    let ended = false;
    return () => {
      if (ended) return;
      ended = true;
      const left = this.plain.get(topic)! - 1;
      if (left > 0) this.plain.set(topic, left);
      else {
        this.plain.delete(topic);
        this.topics(false, [topic]);
      }
    };
  }

  private addStream(performer: string, stream: Stream, mode: Mode): () => void {
    const topic = frameTopic(performer, stream);
    let state = this.streams.get(topic);
    if (!state) {
      state = {
        performer,
        stream,
        everyFrame: new Reader(),
        latest: new Reader(),
        raw: undefined,
        frames: 0,
      };
      this.streams.set(topic, state);
      this.topics(true, [topic]);
      this.await(performer);
    }
    const counted = state;
    if (counted[mode].users === 0) counted[mode] = new Reader();
    ++counted[mode].users;
    const endBody = this.addPlain(`body/${performer}/`);
    let ended = false;
    return () => {
      if (ended) return;
      ended = true;
      endBody();
      --counted[mode].users;
      if (counted.everyFrame.users + counted.latest.users > 0) return;
      this.streams.delete(topic);
      this.topics(false, [topic]);
      if (![...this.streams.values()].some((other) => other.performer === performer)) this.unawait(performer);
    };
  }

  // A name that is misspelt gives silence: that is said, once a daemon has had time to answer.
  private await(performer: string): void {
    if (!this.daemonState_.up || this.bodies.has(performer) || this.awaited.has(performer)) return;
    this.awaited.set(performer, setTimeout(() => {
      this.emit('complaint',
        `found nobody called ${performer}, expected SOURCE.NAME of who performs; frames come when there is one`, performer);
    }, UNKNOWN_MS));
  }
  private unawait(performer: string): void {
    clearTimeout(this.awaited.get(performer));
    this.awaited.delete(performer);
  }

  private onLink(state: LinkState): void {
    this.linkState_ = state;
    if (state.kind === 'open') {
      this.topics(true, [...this.plain.keys(), ...this.streams.keys()]);
    } else {
      for (const id of [...this.pending.keys()]) {
        this.settle(id)!.reject(new NoAnswerError('the connection to the gateway broke'));
      }
      this.setDaemon({ up: false, reason: 'not connected to the gateway' });
    }
    this.emit('link', state);
  }

  private setDaemon(state: DaemonState): void {
    if (state.up === this.daemonState_.up && state.reason === this.daemonState_.reason) return;
    this.daemonState_ = state;
    if (state.up) for (const { performer } of this.streams.values()) this.await(performer);
    else for (const performer of [...this.awaited.keys()]) this.unawait(performer);
    this.emit('daemon', state);
  }

  private onNotice(text: string): void {
    let notice: Record<string, unknown>;
    try {
      notice = JSON.parse(text) as Record<string, unknown>;
    } catch {
      return;
    }
    if (typeof notice.watchOnly === 'boolean') this.watchOnly_ = notice.watchOnly;
    if (notice.daemon) this.setDaemon(notice.daemon as DaemonState);
    if (typeof notice.error === 'string') this.emit('complaint', notice.error);
    if (typeof notice.unanswered === 'string') {
      this.settle(BigInt(notice.unanswered))?.reject(new NoAnswerError(String(notice.reason)));
    }
  }

  private onBinary(bytes: Uint8Array): void {
    const length = bytes[0];
    if (length === undefined || bytes.length < 1 + length) return;
    const payload = bytes.subarray(1 + length);
    if (length > 0) {
      this.onPublished(String.fromCharCode(...bytes.subarray(1, 1 + length)), payload);
      return;
    }
    const reply = this.parse(ReplySchema, payload, 'reply');
    if (reply) this.onReply(reply);
  }

  // Undefined, and a complaint, where `payload` is no such message.
  private parse<S extends DescMessage>(schema: S, payload: Uint8Array, what: string) {
    try {
      return fromBinary(schema, payload);
    } catch (error) {
      this.emit('complaint', `${what}: ${(error as Error).message}`);
      return undefined;
    }
  }

  private onReply(reply: Reply): void {
    const pending = this.settle(reply.id);
    if (!pending) return;
    if (reply.code === Code.OK) pending.resolve(reply);
    else pending.reject(new RefusedError(reply.code, reply.reason));
  }

  private onPublished(topic: string, payload: Uint8Array): void {
    const state = this.streams.get(topic);
    if (state) {
      ++state.frames;
      ++state.everyFrame.sinceLast;
      ++state.latest.sinceLast;
      if (state.latest.users > 0) state.raw = payload;
      if (state.everyFrame.users > 0) {
        const update = this.accept(state, state.everyFrame, payload);
        if (update) this.emit('frame', update);
      }
      return;
    }
    const parsed = parseTopic(topic);
    if (parsed?.kind === 'stats') {
      const stats = this.parse(StatsSchema, payload, topic);
      if (stats) this.emit('stats', stats);
    } else if (parsed?.kind === 'body') {
      const body = this.parse(BodySchema, payload, topic);
      if (body) this.onBody(parsed.performer, body);
    }
  }

  private onBody(performer: string, body: Body): void {
    const wrong = checkBody(body);
    this.unawait(performer);
    if (wrong) return this.emit('complaint', `body of ${performer}: ${wrong}`);
    const known = this.bodies.get(performer) ?? [];
    if (known.some((other) => other.hash === body.hash && other.output === body.output)) return;
    // All outputs, and what each was before: frames of it may still be under way.
    this.bodies.set(performer, [...known.slice(1 - MAX_BODIES), body]);
    this.emit('body', body);
  }

  private accept(state: StreamState, reader: Reader, payload: Uint8Array): Update | undefined {
    const frame = this.parse(FrameSchema, payload, `frame of ${state.performer}`);
    if (!frame) return undefined;
    if (frame.output !== (state.stream === 'canonical' ? Output.CANONICAL : Output.RIG)) {
      this.emit('complaint', `frame of ${state.performer}: of another output than its topic`);
      return undefined;
    }
    const sameEpoch = reader.started && frame.epoch === reader.epoch;
    if (sameEpoch && frame.sequence < reader.sequence) return undefined;
    const body = this.bodies
      .get(state.performer)
      ?.find((known) => known.hash === frame.bodyHash && known.output === frame.output);
    const wrong = body ? checkFrame(body, frame) : '';
    if (wrong) {
      this.emit('complaint', `frame of ${state.performer}: ${wrong}`);
      return undefined;
    }
    const step = sameEpoch ? Number(frame.sequence - reader.sequence) : reader.sinceLast;
    const skipped = Math.max(0, reader.sinceLast - 1);
    const newEpoch = reader.started && !sameEpoch;
    reader.started = true;
    reader.epoch = frame.epoch;
    reader.sequence = frame.sequence;
    const missed = Math.max(0, step - reader.sinceLast);
    reader.sinceLast = 0;
    return {
      performer: state.performer,
      stream: state.stream,
      frame,
      body,
      missed,
      skipped,
      newEpoch,
    };
  }
}
