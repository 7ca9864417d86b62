// Records one performer: every received frame of the input and of the styled motion, on the rig's skeleton and
// on the canonical humanoid.
import type { Body, StyledClient, Stats, Update } from 'styled-client';

import { Track, type Take } from './take.js';

/** Limits of a take: half an hour at 120 Hz for a skeleton of usual size. */
export interface Limits {
  poses: number; // per stream
  bytes: number; // for all
}
const LIMITS: Limits = { poses: 30 * 60 * 120, bytes: 384 << 20 };
const SILENT_STATS = 3; // statistics messages, one per second: a short pause of the rig is tolerated

export interface Ended {
  take: Take | undefined; // undefined: no frame arrived
  /** Why it ended by itself; '' if the user ended it. */
  reason: string;
}

export class Recorder {
  /** Called during recording. */
  performer = '';
  take: Take | undefined;
  onEnd: (ended: Ended) => void = () => {};
  private silent = 0;
  private epoch: bigint | undefined;
  private ends: (() => void)[] = [];

  constructor(
    private readonly client: StyledClient,
    private readonly limits: Limits = LIMITS,
  ) {
    client.on('frame', (update) => this.onFrame(update));
    client.on('daemon', ({ up, reason }) => {
      if (up) return;
      // Without the gateway the daemon's state is unknown.
      if (client.linkState.kind !== 'open') return this.end('the connection to the gateway, styleweb, broke');
      this.end(`the daemon went away${reason ? ` (${reason})` : ''}`);
    });
    client.on('stats', (stats) => this.onStats(stats));
  }

  get recording(): boolean {
    return this.performer !== '';
  }
  /** Seconds recorded, by the daemon's clock. */
  get elapsed_s(): number {
    const track = this.take?.styled;
    return track && track.length > 0 ? track.daemon_s(track.length - 1) - track.daemon_s(0) : 0;
  }
  get frames(): number {
    return this.take?.styled.length ?? 0;
  }
  get missed(): number {
    return this.take?.styled.missed ?? 0;
  }

  start(performer: string): void {
    if (this.recording) return;
    this.performer = performer;
    this.take = undefined;
    this.epoch = undefined;
    this.silent = 0;
    this.ends = (['source', 'rig', 'canonical'] as const).map((stream) => this.client.subscribe(performer, stream));
  }

  /** `reason`: why, if the user did not request it. */
  stop(reason = ''): void {
    this.end(reason);
  }

  private end(reason: string): void {
    if (!this.recording) return;
    for (const end of this.ends) end();
    this.performer = '';
    this.onEnd({ take: this.take, reason });
  }

  private begin(update: Update, body: Body): Take {
    this.epoch = update.frame.epoch;
    const joints = body.names.length;
    return { performer: this.performer, body, begun: new Date(), source: new Track(joints), styled: new Track(joints) };
  }

  private onFrame(update: Update): void {
    const { performer, stream, frame, body } = update;
    if (performer !== this.performer) return;
    if (stream === 'canonical') return this.onCanonical(update);
    if (this.take && frame.epoch !== this.epoch) return this.end('the daemon was restarted');
    if (this.take && frame.bodyHash !== this.take.body.hash) return this.end(`${performer} has another skeleton now`);
    if (!body) return; // it has not arrived yet
    this.take ??= this.begin(update, body);
    const track = stream === 'source' ? this.take.source : this.take.styled;
    track.add(frame);
    const { source, styled, canonical } = this.take;
    if (track.length >= this.limits.poses || source.bytes + styled.bytes + (canonical?.track.bytes ?? 0) >= this.limits.bytes) {
      this.end(`${track.length} frames is the limit of a recording here; stylerec has none`);
    }
  }

  // Before the first frame of the rig there is no take, and after a change of body nothing more is
  // recorded.
  private onCanonical({ frame, body }: Update): void {
    if (!this.take || !body || frame.epoch !== this.epoch) return;
    this.take.canonical ??= { body, track: new Track(body.names.length) };
    if (frame.bodyHash === this.take.canonical.body.hash) this.take.canonical.track.add(frame);
  }

  private onStats(stats: Stats): void {
    if (!this.recording) return;
    const entry = stats.performers.find(({ performer }) => performer === this.performer);
    if (!entry) return this.end(`${this.performer} left`);
    this.silent = entry.live ? 0 : this.silent + 1;
    if (this.silent >= SILENT_STATS) this.end(`${this.performer} went silent`);
  }
}
