// Plays a take on the stage, picture by picture, for a video: the recorded motion, not the live
// one.
import { create } from '@bufbuild/protobuf';
import { FrameSchema, type Body, type Frame, type Stream } from 'styled-client';

import { TrackReader, filledIn, gridOf, type Grid, type Take, type Track } from './take.js';

interface Played {
  body: Body;
  track: Track;
  reader: TrackReader;
}

export class Replay {
  /** Seconds of the take. */
  readonly duration_s: number;
  readonly rate_hz: number;
  /** Of the take, at that rate. */
  readonly frames: number;
  private readonly streams = new Map<Stream, Played>();

  private constructor(readonly take: Take, private readonly grid: Grid) {
    this.frames = grid.frames;
    this.rate_hz = grid.rate_hz;
    this.duration_s = grid.frames / grid.rate_hz;
    const { source, styled, canonical } = take;
    const add = (stream: Stream, body: Body, track: Track, slots: number[]) =>
      this.streams.set(stream, { body, track, reader: new TrackReader(track, slots) });
    add('source', take.body, source, grid.slots[0]!);
    add('rig', take.body, styled, grid.slots[1]!);
    if (canonical && grid.slots[2]) add('canonical', canonical.body, canonical.track, grid.slots[2]);
  }

  /** undefined: the take is too short. `shared`: the grid of the input and the styled motion. */
  static of(take: Take, shared = gridOf([take.source, take.styled])): Replay | undefined {
    const { source, styled, canonical } = take;
    const whole = canonical && gridOf([source, styled, canonical.track]);
    const grid = whole && whole.frames > 1 ? whole : shared;
    return grid && grid.frames > 1 ? new Replay(take, grid) : undefined;
  }

  /** The styled motion of the canonical humanoid, if it was recorded. */
  get canonical(): { body: Body; faceNames: readonly string[] } | undefined {
    const played = this.streams.get('canonical');
    return played && { body: played.body, faceNames: played.track.faceNames };
  }

  /** Frames of a stream that did not arrive. */
  filled(stream: 'source' | 'rig' | 'canonical'): number {
    return filledIn(this.grid, ['source', 'rig', 'canonical'].indexOf(stream));
  }

  /** The frame at a time from the take's start, in seconds; times must not go back. */
  at(stream: Stream, time_s: number): { body: Body; frame: Frame } | undefined {
    const played = this.streams.get(stream);
    if (!played) return undefined;
    const { first, frames, step, rate_hz } = this.grid;
    const { body, track, reader } = played;
    const place = first + Math.min(frames - 1, time_s * rate_hz) * step;
    const pose = [...reader.at(place)], i = reader.index(place);
    return {
      body,
      frame: create(FrameSchema, {
        performer: this.take.performer, bodyHash: body.hash, output: body.output,
        rootPosition: pose.slice(0, 3), rotations: pose.slice(3), contacts: track.contacts(i),
        expressions: track.face(i), props: reader.props(place),
      }),
    };
  }
}
