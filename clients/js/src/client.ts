import {
  create,
  fromBinary,
  toBinary,
  type DescMessage,
  type MessageInitShape,
} from '@bufbuild/protobuf';

import { checkChange, checkDesign, checkName, checkOptions, shown, type SetInit } from './checks.js';
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
  type LikeReply,
  type ListReply,
  type PreviewReply,
  type Reply,
  type StatusReply,
  type StyleFile,
} from './gen/proto/styled/v1/control_pb.js';
import type { FrameFate } from './gen/proto/styled/v1/fate_pb.js';
import { FrameSchema, type Frame } from './gen/proto/styled/v1/frame_pb.js';
import { StatsSchema, type Stats } from './gen/proto/styled/v1/stats_pb.js';
import { checkBody, checkFrame } from './kinematics.js';
import { Link, type LinkState } from './link.js';
import { checkPerformer, checkPerformers, frameTopic, parseTopic, type Stream } from './topics.js';

const MAX_BODIES = 64; // per performer
const LONG: ReadonlySet<string | undefined> = new Set(['like', 'preview', 'exportStyle', 'importStyle']);
const UNKNOWN_MS = 2000; // the daemon answers a subscription with bodies at once

/** The daemon's state, as the gateway reports it. */
export interface DaemonState {
  up: boolean;
  reason: string;
}

/** One frame, with its skeleton and the number of missed frames before it. */
export interface Update {
  performer: string;
  stream: Stream;
  frame: Frame;
  /** Its skeleton, checked; undefined until it has arrived. */
  body: Body | undefined;
  /** Frames of this stream directly before this one that did not arrive: lost in transit, or dropped by
   * the gateway because this client did not read. */
  missed: number;
  /** Older frames that arrived and that this one superseded; for `latest` only. */
  skipped: number;
  /** The daemon restarted since the previous frame of this stream. */
  newEpoch: boolean;
}

export interface ClientEvents {
  link(state: LinkState): void;
  daemon(state: DaemonState): void;
  frame(update: Update): void;
  body(body: Body): void;
  stats(stats: Stats): void;
  /** A message that the gateway did not understand or refused. Also, once for each subscribed performer
   * for which the daemon sent no body; that performer may still appear. `unknown` is its name. */
  complaint(text: string, unknown?: string): void;
  /** A change was applied, but is not visible: no performer of that name is present (the change waits for
  it), or the strength is 0. */
  unseen(text: string, performer: string): void;
}

export interface ClientOptions {
  /** The address of styleweb: "http://127.0.0.1:7080", or its WebSocket "ws://127.0.0.1:7080/ws". */
  url: string;
  token?: string;
  /** Time limit of one control request; default 3000. */
  timeout_ms?: number;
  /** The same for requests that take long: examples, previews, style files; default 12000. */
  long_ms?: number;
}

type Mode = 'everyFrame' | 'latest';

// The position of one kind of subscriber in a stream. Both kinds may be subscribed at once, and a
// frame delivered to one of them may still be pending for the other.
class Reader {
  users = 0;
  sinceLast = 0; // arrived since the last one that was delivered
  epoch = 0n;
  sequence = 0n;
  started = false;
}

interface StreamState {
  performer: string;
  stream: Stream;
  everyFrame: Reader; // each frame is parsed when it arrives
  latest: Reader; // only the newest frame is parsed, on request
  raw: Uint8Array | undefined; // the newest, not parsed yet
  frames: number; // arrived
}

interface Pending {
  resolve(reply: Reply): void;
  reject(error: Error): void;
  timer: ReturnType<typeof setTimeout>;
}

/** The pose in which a performer is calibrated, and the parts of the rig that are calibrated. */
export interface CalibrateOptions {
  /** 't': arms sideways, palms down (default); 'n': arms hanging, palms at the thighs. */
  pose?: keyof typeof POSES;
  /** For rigs without a skeleton: the sensors' mounting and heading ('full', default), heading only
   * ('yaw'), or 'mounting' in the rig's own second pose. */
  sensors?: keyof typeof SENSORS;
  /** Discard the calibration instead. */
  clear?: boolean;
  /** Instead of a pose, calibrate the performer's neutral: they stand and walk in their own way for `seconds`,
  1 to 60 (default 5), after the reply. */
  neutral?: boolean;
  seconds?: number;
}

/** An example of a style: one of clip, learnS, code, vary and design. */
export interface LikeOptions {
  /** Name of the style: 1 to 32 of A-Z a-z 0-9 _ -. An earlier example of this name is replaced.
  With `measure` it may be left out. */
  name?: string;
  /** The bytes of a BVH, glTF binary or VRMA file. */
  clip?: Uint8Array;
  /** Its name, for messages and lists. */
  file?: string;
  /** The dialect of its skeleton; by default detected. */
  rig?: string;
  /** The performer's motion from now on, for this many seconds, 1 to 60. */
  learnS?: number;
  /** The numbers from an earlier reply. */
  code?: number[];
  /** A variation of one of the weights' styles. */
  vary?: { style: string; seed: bigint; amount?: number };
  /** By hand, as in `design`. */
  design?: Pick<DesignOptions, 'from' | 'preset' | 'sliders'>;
  /** The code of a neutral example of the same performer: only the difference from it is used. */
  neutralCode?: number[];
  /** Makes no style: the reply has code, nearest and distance, and what was found. */
  measure?: boolean;
  /** The network that gets the style, by StyleInfo.model or its family; by default the example decides.
  For clip and learnS. */
  network?: string;
  /** Adds the example to the made style of that name: the mean of what both show. */
  add?: boolean;
  transitionMs?: number;
}

/** A style by hand: what it begins with, and its sliders. */
export interface DesignOptions {
  /** Name of the style; by default by-hand- and the performer. A style of that name that was made by hand
  changes at once, without a fade. */
  name?: string;
  /** The style to begin with; by default the made style of that name, or a neutral performer. */
  from?: string;
  /** Begins with this design of ListReply.designs, or with 'neutral': its sliders are set first. */
  preset?: string;
  /** By name, in the units of ListReply.sliders; the others keep their value. */
  sliders?: Record<string, number>;
  transitionMs?: number;
}

const POSES = { t: Calibrate_Pose.T, n: Calibrate_Pose.N };
const SENSORS = {
  full: Calibrate_Sensors.FULL,
  yaw: Calibrate_Sensors.YAW,
  mounting: Calibrate_Sensors.MOUNTING,
};

// The enum value for a word.
function wordOf<T extends Record<string, number>>(words: T, word: keyof T & string, what: string): T[keyof T & string] {
  if (!Object.hasOwn(words, word)) {
    throw new TypeError(`found "${word}" as ${what}, expected ${Object.keys(words).join(', ')}`);
  }
  return words[word];
}

const EVENTS = ['link', 'daemon', 'frame', 'body', 'stats', 'complaint', 'unseen'] satisfies (keyof ClientEvents)[];

type RequestInit = MessageInitShape<typeof RequestSchema>;

function socketUrl(options: ClientOptions): string {
  let url: URL | undefined;
  try {
    url = new URL(options.url);
  } catch {
    // reported below
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
 * A subscriber and control client of a styled daemon, through styleweb. Connects in the background,
 * reconnects by itself, and keeps its subscriptions. Every-frame streams call back in order, with gaps
 * counted. A renderer polls latest-wins streams with `latest` when it draws, and only the frames that it
 * draws are parsed.
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
  private readonly long_ms: number;
  private nextId = 1n;
  private linkState_: LinkState = { kind: 'connecting', reason: '' };
  private daemonState_: DaemonState = { up: false, reason: 'not connected yet' };
  private watchOnly_ = false;
  private warned = '';

  constructor(options: ClientOptions) {
    checkOptions(options);
    this.timeout_ms = options.timeout_ms ?? 3000;
    this.long_ms = options.long_ms ?? 12000;
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
  /** The gateway refuses all changes (--watch-only). */
  get watchOnly(): boolean {
    return this.watchOnly_;
  }

  /** Returns a function that removes the listener. */
  on<K extends keyof ClientEvents>(event: K, listener: ClientEvents[K]): () => void {
    if (!(EVENTS as string[]).includes(event)) {
      throw new TypeError(`found ${shown(event)} as event, expected ${EVENTS.join(', ')}`);
    }
    const set = this.listeners.get(event) ?? new Set();
    this.listeners.set(event, set);
    set.add(listener as (...args: never[]) => void);
    return () => set.delete(listener as (...args: never[]) => void);
  }

  // ---- Subscriptions. Each function returns a function that ends the subscription.

  /** Every frame, in order, as "frame" events. */
  subscribe(performer: string, stream: Stream = 'rig'): () => void {
    return this.addStream(performer, stream, 'everyFrame');
  }

  /** The newest frame, on each call of `latest`. */
  subscribeLatest(performer: string, stream: Stream = 'rig'): () => void {
    return this.addStream(performer, stream, 'latest');
  }

  /** Statistics once a second, as "stats" events. */
  subscribeStats(): () => void {
    return this.addPlain('stats/');
  }

  /** The bodies of all performers, including later ones, as "body" events. */
  subscribeBodies(): () => void {
    return this.addPlain('body/');
  }

  /**
   * The newest frame of a stream of subscribeLatest that was not returned before; undefined if there is
   * none.
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

  // ---- Control. Each call rejects with RefusedError or NoAnswerError, or with TypeError (before
  // anything is sent) for an invalid argument. `performer` is SOURCE.NAME or "*", all performers.

  async list(): Promise<ListReply> {
    return (await this.ask({ command: { case: 'list', value: {} } })).list!;
  }
  async status(): Promise<StatusReply> {
    return (await this.ask({ command: { case: 'status', value: {} } })).status!;
  }
  /** Changes the settings that are present in `change`. */
  async set(performer: string, change: SetInit): Promise<Applied[]> {
    checkChange(change);
    return this.change(performer, { case: 'set', value: change });
  }
  setStyle(performer: string, style: string, strength = 1): Promise<Applied[]> {
    return this.set(performer, { mix: [{ style, weight: 1 }], strength });
  }
  clear(performer: string): Promise<Applied[]> {
    return this.set(performer, { clear: true });
  }
  async preset(performer: string, name: string, transitionMs?: number): Promise<Applied[]> {
    checkName(name, 'preset');
    const value = { name, ...(transitionMs === undefined ? {} : { transitionMs }) };
    return this.change(performer, { case: 'preset', value });
  }
  pin(performer: string, pinned: boolean): Promise<Applied[]> {
    return this.change(performer, { case: 'pin', value: { pinned } });
  }
  reset(performer: string): Promise<Applied[]> {
    return this.change(performer, { case: 'reset', value: {} });
  }
  /** Calibrates one performer, who stands in this pose at this moment, or shows their neutral from now on. */
  async calibrate(performer: string, options: CalibrateOptions = {}): Promise<CalibrateReply> {
    checkPerformer(performer);
    const { pose = 't', sensors = 'full', clear = false, neutral = false, seconds = neutral ? 5 : 0 } = options;
    const value = { pose: wordOf(POSES, pose, 'pose'), sensors: wordOf(SENSORS, sensors, 'sensors'), clear, neutral, seconds };
    return (await this.ask({ performer, command: { case: 'calibrate', value } })).calibrate!;
  }
  /** Makes a style from an example, for all clients, and sets the performer to it (SOURCE.NAME, "*",
  or "": no performer). The reply has the example's distance from the styles that the weights know. */
  async like(performer: string, example: LikeOptions): Promise<LikeReply> {
    if (performer !== '') checkPerformers(performer);
    const command = { case: 'like', value: example } as const;
    const reply = await this.ask({ performer, command });
    this.tellUnseen(performer, command, reply.applied);
    return reply.like!;
  }
  /** Makes a style by hand, or moves its sliders, and sets the performer to it (as `like`). */
  async design(performer: string, options: DesignOptions): Promise<LikeReply> {
    checkDesign(options);
    const { name = '', transitionMs, ...design } = options;
    return this.like(performer, { name, design, ...(transitionMs === undefined ? {} : { transitionMs }) });
  }
  /** The file of a style that was made. */
  async exportStyle(name: string): Promise<StyleFile> {
    return (await this.ask({ command: { case: 'exportStyle', value: { name } } })).styleFile!;
  }
  /** Adds the style of such a file, for all clients. `name`: by default the file's own; `replace`: replaces a
  made style of this name. */
  async importStyle(file: Uint8Array, options: { name?: string; replace?: boolean } = {}): Promise<LikeReply> {
    return (await this.ask({ command: { case: 'importStyle', value: { file, ...options } } })).like!;
  }
  /** Renames a made style. Performers that show it continue; the result names them. */
  async renameStyle(name: string, to: string): Promise<Applied[]> {
    return (await this.ask({ command: { case: 'renameStyle', value: { name, to } } })).applied;
  }
  /** Removes a made style. Performers that show it, named in the result, fade to bypass. */
  async removeStyle(name: string): Promise<Applied[]> {
    return (await this.ask({ command: { case: 'removeStyle', value: { name } } })).applied;
  }
  /**
   * The fates of a performer's frames, with their causes: of the frame with a number (Frame.sequence), or
   * of the newest ones, up to 1,024. Each has a sentence in `text`.
   */
  async explain(performer: string, which: { sequence?: bigint; last?: number } = {}): Promise<FrameFate[]> {
    const value = which.sequence === undefined ? { last: which.last ?? 1 } : { sequence: which.sequence };
    return (await this.ask({ performer, command: { case: 'explain', value } })).explain!.frames;
  }
  /** A small moving figure of any style: two strides that loop. */
  async preview(style: string): Promise<PreviewReply> {
    return (await this.ask({ command: { case: 'preview', value: { style } } })).preview!;
  }
  /** Fires the cues with that name in the daemon's configuration. */
  async cue(name: string): Promise<Applied[]> {
    checkName(name, 'cue');
    return this.change('*', { case: 'cue', value: { name } });
  }
  /** Sets all performers to bypass, pinned or not. */
  async panic(): Promise<Applied[]> {
    return (await this.ask({ command: { case: 'panic', value: {} } })).applied;
  }

  private async change(performer: string, command: RequestInit['command']): Promise<Applied[]> {
    checkPerformers(performer);
    const { applied } = await this.ask({ performer, command });
    this.tellUnseen(performer, command, applied);
    return applied;
  }

  // Only for named performers: "*" means none in particular, and a strength of 0 in the change itself is
  // intended.
  private tellUnseen(performer: string, command: RequestInit['command'], applied: Applied[]): void {
    const styles = command?.case === 'preset' || command?.case === 'cue' || command?.case === 'like' ||
      (command?.case === 'set' && command.value.strength === undefined);
    for (const one of applied) {
      if (one.absent && one.performer === performer) {
        this.tell('unseen', `no performer of the name ${performer} is present: the change waits for it`, performer);
      }
      if (one.noStrength && styles) {
        this.tell('unseen', `the strength of ${one.performer} is 0: no style is visible`, one.performer);
      }
      if (one.notVaried && styles) {
        this.tell('unseen', `${one.performer}: ${one.notVaried} has no variations and is shown as it is`,
                  one.performer);
      }
      if (one.refused) {
        this.tell('unseen', `not changed: ${one.refused}`, one.performer);
      }
    }
  }

  /** Sends any request, unchecked; the client sets its id. */
  ask(request: RequestInit): Promise<Reply> {
    const id = this.nextId++;
    return new Promise((resolve, reject) => {
      const bytes = toBinary(RequestSchema, create(RequestSchema, { ...request, id }));
      if (!this.link.send(bytes)) {
        reject(new NoAnswerError('not connected to the gateway', false));
        return;
      }
      // The reply to a take is sent after it.
      const command = request.command;
      const taken_s = command?.case === 'like' ? (command.value.learnS ?? 0) : 0;
      const timeout_ms = (LONG.has(command?.case) ? this.long_ms : this.timeout_ms) + 1000 * taken_s;
      const timer = setTimeout(() => {
        this.settle(id)?.reject(new NoAnswerError(`no answer within ${timeout_ms} ms`));
      }, timeout_ms);
      this.pending.set(id, { resolve, reject, timer });
    });
  }

  // ---- Internals

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

  // An event that reports a problem: without a listener it becomes a warning in the console, once
  // until a different one.
  private tell<K extends 'complaint' | 'unseen'>(event: K, ...args: Parameters<ClientEvents[K]>): void {
    if (this.listeners.get(event)?.size) this.emit(event, ...args);
    else this.warn(args[0]);
  }

  private warn(text: string): void {
    if (text === this.warned) return;
    this.warned = text;
    console.warn(`styled-client: ${text}`);
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

  // A misspelt name would cause silence; so a complaint is emitted once the daemon has had time to
  // reply.
  private await(performer: string): void {
    if (!this.daemonState_.up || this.bodies.has(performer) || this.awaited.has(performer)) return;
    this.awaited.set(performer, setTimeout(() => {
      this.tell('complaint',
        `found no performer ${performer}, expected SOURCE.NAME of a present one; frames arrive once it is present`, performer);
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
    if ('reason' in state && state.reason && !this.listeners.get('link')?.size) this.warn(state.reason);
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
    if (typeof notice.error === 'string') this.tell('complaint', notice.error);
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

  // Undefined, with a complaint, if `payload` is not such a message.
  private parse<S extends DescMessage>(schema: S, payload: Uint8Array, what: string) {
    try {
      return fromBinary(schema, payload);
    } catch (error) {
      this.tell('complaint', `${what}: ${(error as Error).message}`);
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
    if (wrong) return this.tell('complaint', `body of ${performer}: ${wrong}`);
    const known = this.bodies.get(performer) ?? [];
    if (known.some((other) => other.hash === body.hash && other.output === body.output)) return;
    // Keeps the bodies of all outputs, and their previous ones: frames of those may still be in
    // transit.
    this.bodies.set(performer, [...known.slice(1 - MAX_BODIES), body]);
    this.emit('body', body);
  }

  private accept(state: StreamState, reader: Reader, payload: Uint8Array): Update | undefined {
    const frame = this.parse(FrameSchema, payload, `frame of ${state.performer}`);
    if (!frame) return undefined;
    if (frame.output !== (state.stream === 'canonical' ? Output.CANONICAL : Output.RIG)) {
      this.tell('complaint', `frame of ${state.performer}: of another output than its topic`);
      return undefined;
    }
    const sameEpoch = reader.started && frame.epoch === reader.epoch;
    if (sameEpoch && frame.sequence < reader.sequence) return undefined;
    const body = this.bodies
      .get(state.performer)
      ?.find((known) => known.hash === frame.bodyHash && known.output === frame.output);
    const wrong = body ? checkFrame(body, frame) : '';
    if (wrong) {
      this.tell('complaint', `frame of ${state.performer}: ${wrong}`);
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
