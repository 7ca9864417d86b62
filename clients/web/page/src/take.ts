// The contents of a recording: poses as received, and the uniform time grid that a BVH file and a video
// need.
import type { Body, Frame } from 'styled-client';

const PIECE = 256; // poses per array
const MOMENT = 5; // numbers per pose that describe its time, and its contacts
const DISAGREE_S = 0.5; // if two clocks differ by more over one step, the rig's clock restarted
const FORGET = 0.9; // fraction of a pose's timing error that is carried over to the next one
const SAME_RATE = 4e-4;
// Rates of rigs and cameras; a measured rate near one of them is taken as that rate.
const USUAL_HZ = [24, 25, 30, 48, 50, 60, 72, 75, 80, 90, 100, 120, 144, 150, 180, 200, 240];
const NEAR_RATE = 0.02;
const AT = 1e-6; // of a grid step: counts as on it

/** A face's values by name. */
export type Face = { name: string; value: number }[];

/** An object that the rig tracks besides the body, if a frame has it. */
export interface PropPose {
  name: string;
  position: number[];
  rotation: number[]; // x, y, z, w
}
const OF_PROP = 7; // numbers: position, rotation

/** The poses of one stream, in order. A pose: 3 of the root, then 4 (x, y, z, w) per joint. */
export class Track {
  readonly width: number;
  length = 0;
  /** Published frames that did not arrive, by gaps in `sequence`. */
  missed = 0;
  private readonly poses: Float32Array[] = [];
  // MOMENT numbers each: sequence, the rig's time (s), the daemon's time (s), the rig's own
  // sequence, bits of contacts
  private readonly moments: Float64Array[] = [];
  /** Of all expressions that arrived. */
  readonly faceNames: string[] = [];
  private readonly faces: (Float32Array | undefined)[] = []; // by faceNames, as many as were known
                                                             // at that time
  private besidesBytes = 0; // of faces and props
  private readonly propNames: string[] = [];
  private readonly props: (Float32Array | undefined)[] = []; // by propNames, as many as were known
                                                             // at that time; NaN: absent

  constructor(joints: number) {
    this.width = 3 + 4 * joints;
  }

  get bytes(): number {
    return this.poses.length * PIECE * (4 * this.width + 8 * MOMENT) + this.besidesBytes;
  }

  /** False if it is not newer than the last one. */
  add(frame: Frame): boolean {
    const sequence = Number(frame.sequence);
    if (this.length > 0) {
      const step = sequence - this.sequence(this.length - 1);
      if (step <= 0) return false;
      this.missed += step - 1;
    }
    const at = this.length % PIECE;
    if (at === 0) {
      this.poses.push(new Float32Array(PIECE * this.width));
      this.moments.push(new Float64Array(PIECE * MOMENT));
    }
    const pose = this.poses.at(-1)!;
    pose.set(frame.rootPosition, at * this.width);
    pose.set(frame.rotations, at * this.width + 3);
    const seconds = (ns: bigint) => Number(ns / 1000n) / 1e6;
    this.moments.at(-1)!.set(
      [sequence, seconds(frame.sourceTimeNs), seconds(frame.receiveTimeNs), Number(frame.sourceSequence), frame.contacts], MOMENT * at);
    ++this.length;
    this.addFace(frame.expressions);
    this.addProps(frame.props);
    return true;
  }

  private addFace(face: Face): void {
    if (face.length === 0) return void this.faces.push(undefined);
    for (const { name } of face) if (!this.faceNames.includes(name)) this.faceNames.push(name);
    const values = new Float32Array(this.faceNames.length);
    for (const { name, value } of face) values[this.faceNames.indexOf(name)] = value;
    this.faces.push(values);
    this.besidesBytes += values.byteLength;
  }
  private addProps(props: PropPose[]): void {
    if (props.length === 0) return void this.props.push(undefined);
    for (const { name } of props) if (!this.propNames.includes(name)) this.propNames.push(name);
    const values = new Float32Array(OF_PROP * this.propNames.length).fill(NaN);
    for (const { name, position, rotation } of props) {
      const turned = Math.hypot(...rotation) > 0 ? rotation : [0, 0, 0, 1];
      values.set([...position, ...turned].slice(0, OF_PROP), OF_PROP * this.propNames.indexOf(name));
    }
    this.props.push(values);
    this.besidesBytes += values.byteLength;
  }
  face(i: number): Face {
    return [...(this.faces[i] ?? [])].map((value, at) => ({ name: this.faceNames[at]!, value }));
  }

  /** By name: position and rotation of each prop that the frame has. */
  propsOf(i: number): Map<string, Float32Array> {
    const values = this.props[i] ?? new Float32Array();
    return new Map(this.propNames.slice(0, values.length / OF_PROP)
      .map((name, at) => [name, values.subarray(OF_PROP * at, OF_PROP * (at + 1))] as const).filter(([, pose]) => !Number.isNaN(pose[0])));
  }

  pose(i: number): Float32Array {
    return this.poses[Math.floor(i / PIECE)]!.subarray((i % PIECE) * this.width, ((i % PIECE) + 1) * this.width);
  }
  sequence(i: number): number {
    return this.moment(i, 0);
  }
  rig_s(i: number): number {
    return this.moment(i, 1);
  }
  daemon_s(i: number): number {
    return this.moment(i, 2);
  }
  sourceSequence(i: number): number {
    return this.moment(i, 3);
  }
  contacts(i: number): number {
    return this.moment(i, 4);
  }
  private moment(i: number, which: number): number {
    return this.moments[Math.floor(i / PIECE)]![MOMENT * (i % PIECE) + which]!;
  }
}

/** One recording: a performer's input and styled motion, both on the rig's own skeleton. */
export interface Take {
  performer: string;
  body: Body;
  begun: Date;
  source: Track;
  styled: Track;
  /** The styled motion of the canonical humanoid. */
  canonical?: { body: Body; track: Track };
}

/** The index of each pose of the tracks in the rig's steps, and the range that all tracks cover, in frames
of 1/rate_hz. `step`: a frame in the rig's steps; 1, unless the rig keeps its nominal rate only
approximately. */
export interface Grid {
  rate_hz: number;
  first: number;
  frames: number;
  step: number;
  /** By track, by pose. */
  slots: number[][];
}

interface Moment {
  sequence: number;
  rig_s: number;
  daemon_s: number;
}

// The moments of all tracks, each sequence once: its times are the same in every track.
function momentsOf(tracks: Track[]): Moment[] {
  const moments = new Map<number, Moment>();
  for (const track of tracks) {
    for (let i = 0; i < track.length; ++i) {
      const sequence = track.sequence(i);
      moments.set(sequence, { sequence, rig_s: track.rig_s(i), daemon_s: track.daemon_s(i) });
    }
  }
  return [...moments.values()].sort((a, b) => a.sequence - b.sequence);
}

// By the rig's clock, which contains no network jitter; by the daemon's if the rig's stands still
// or jumps.
function step_s(a: Moment, b: Moment): number {
  const rig = b.rig_s - a.rig_s, daemon = b.daemon_s - a.daemon_s;
  return rig > 0 && Math.abs(rig - daemon) < DISAGREE_S ? rig : Math.max(0, daemon);
}

// The nominal rate: "120" for 119.998, as poses arrive, and for 119.2 as well, then with `step`
// other than 1, so that the file's time is correct to its end. `steps`: the number of measured
// steps.
function rateMeant(rate_hz: number, steps: number): { rate_hz: number; step: number } {
  const ntsc = (near_hz: number) => (near_hz * 1000) / 1001;
  for (const meant_hz of [Math.round(rate_hz), ntsc(Math.round(rate_hz * 1.001))]) {
    const apart = Math.abs(rate_hz / meant_hz - 1);
    if (meant_hz >= 1 && apart < SAME_RATE && apart * steps < 0.5) return { rate_hz: meant_hz, step: 1 };
  }
  const usual_hz = USUAL_HZ.find((usual) => Math.abs(rate_hz / usual - 1) < NEAR_RATE);
  return usual_hz ? { rate_hz: usual_hz, step: rate_hz / usual_hz } : { rate_hz, step: 1 };
}

/**
 * The grid for the tracks of one take; undefined with fewer than two poses. The grid's step is the median
 * step. Every pose gets its own grid index; the gap before it follows from its time, or its sequence.
 */
export function gridOf(tracks: Track[]): Grid | undefined {
  const moments = momentsOf(tracks);
  if (moments.length < 2 || tracks.some(({ length }) => length === 0)) return undefined;
  const steps_s = moments.slice(1).map((moment, i) => step_s(moments[i]!, moment));
  const each_s = steps_s.map((step, i) => step / (moments[i + 1]!.sequence - moments[i]!.sequence));
  const usual_s = each_s.sort((a, b) => a - b)[Math.floor(each_s.length / 2)]!;
  if (!(usual_s > 0)) return undefined;

  const slotOf = new Map([[moments[0]!.sequence, 0]]);
  let slot = 0, late_s = 0, whole_s = 0;
  steps_s.forEach((step, i) => {
    const sequences = moments[i + 1]!.sequence - moments[i]!.sequence;
    const steps = Math.max(sequences, Math.round((step + late_s) / usual_s));
    // Jitter must not accumulate: the next pose is measured from the expected time of this pose.
    late_s = FORGET * (step + late_s - steps * usual_s);
    slot += steps;
    whole_s += step;
    slotOf.set(moments[i + 1]!.sequence, slot);
  });
  const slots = tracks.map((track) =>
    Array.from({ length: track.length }, (_, i) => slotOf.get(track.sequence(i))!));
  const first = Math.max(...slots.map((of) => of[0]!));
  const last = Math.min(...slots.map((of) => of.at(-1)!));
  const { rate_hz, step } = rateMeant(slot / whole_s, slot);
  return { rate_hz, first, frames: Math.max(0, Math.floor((last - first) / step + AT) + 1), step, slots };
}

// The rig's first step behind the frames.
function endOf({ first, frames, step }: Grid): number {
  return frames === 0 ? first : first + Math.floor((frames - 1) * step + AT) + 1;
}

/** The number of the rig's steps without a pose of the track. */
export function filledIn(grid: Grid, track: number): number {
  const { first } = grid, end = endOf(grid);
  return end - first - grid.slots[track]!.filter((slot) => slot >= first && slot < end).length;
}

/** The number of steps without a pose, by cause. */
export interface Causes {
  /** Published by the daemon, but not received: its sequence has a gap. */
  unreached: number;
  /** Numbered by the rig, but not published by the daemon. */
  unpublished: number;
  /** Neither: time passed, but no number is missing. */
  unnumbered: number;
}

export function causesOf(grid: Grid, index: number, track: Track): Causes {
  const slots = grid.slots[index]!;
  const steps = slots.slice(1).map((_, i) => ({
    slots: [slots[i]!, slots[i + 1]!] as const,
    published: track.sequence(i + 1) - track.sequence(i),
    numbered: track.sourceSequence(i + 1) - track.sourceSequence(i),
  }));
  // A rig with several performers may number the frames of all in one sequence.
  const each = steps.map(({ published, numbered }) => numbered / published).sort((a, b) => a - b);
  const usual = each[Math.floor(each.length / 2)] ?? 0;
  const causes: Causes = { unreached: 0, unpublished: 0, unnumbered: 0 };
  for (const { slots: [from, to], published, numbered } of steps) {
    const free = Math.min(to, endOf(grid)) - Math.max(from, grid.first - 1) - 1;
    if (free <= 0) continue;
    const unreached = Math.min(free, published - 1);
    const gone = usual > 0 ? Math.max(0, Math.round(numbered / usual) - published) : 0;
    const unpublished = Math.min(free - unreached, gone);
    causes.unreached += unreached;
    causes.unpublished += unpublished;
    causes.unnumbered += free - unreached - unpublished;
  }
  return causes;
}

/** `causes` in words; '' if nothing was filled in. */
export function causesInWords({ unreached, unpublished, unnumbered }: Causes): string {
  return [
    unreached && `${unreached} did not reach this page`,
    unpublished && `${unpublished} never left the daemon: lost on the way from the rig, or skipped because ` +
      'they were too late',
    unnumbered && `${unnumbered} where time passed between two frames of the rig in a row`,
  ].filter((part) => part).join('; ');
}

// Interpolates from a to b at fraction `share`: linearly for the root, on the shorter arc for
// joints.
function between(a: Float32Array, b: Float32Array, share: number): Float64Array {
  const pose = new Float64Array(a.length);
  for (let i = 0; i < 3; ++i) pose[i] = a[i]! + share * (b[i]! - a[i]!);
  for (let i = 3; i < a.length; i += 4) {
    const length = (q: Float32Array) => Math.hypot(q[i]!, q[i + 1]!, q[i + 2]!, q[i + 3]!);
    const ofA = 1 / length(a), ofB = 1 / length(b);
    let dot = 0;
    for (let k = i; k < i + 4; ++k) dot += a[k]! * ofA * (b[k]! * ofB);
    const angle = Math.acos(Math.min(1, Math.abs(dot)));
    const sine = Math.sin(angle);
    const [wa, wb] = sine < 1e-6 ? [1 - share, share]
      : [Math.sin((1 - share) * angle) / sine, Math.sin(share * angle) / sine];
    const sign = dot < 0 ? -1 : 1;
    for (let k = i; k < i + 4; ++k) pose[k] = wa * a[k]! * ofA + sign * wb * b[k]! * ofB;
  }
  return pose;
}

/** Reads a track at increasing places, in the rig's steps within the range of its grid. */
export class TrackReader {
  private after = 0;

  constructor(private readonly track: Track, private readonly slots: number[]) {}

  /** The pose: as received, or interpolated between its neighbors. */
  at(place: number): Float32Array | Float64Array {
    this.seek(place);
    const next = this.slots[this.after]!;
    if (next - place <= AT || this.after === 0) return this.track.pose(this.after);
    const before = this.slots[this.after - 1]!;
    return between(this.track.pose(this.after - 1), this.track.pose(this.after), (place - before) / (next - before));
  }
  /** The props: as received, or interpolated like the body; one that the next frame lacks stays until that
  frame. */
  props(place: number): PropPose[] {
    this.seek(place);
    const next = this.slots[this.after]!;
    const exact = next - place <= AT || this.after === 0;
    const to = this.track.propsOf(this.after), from = exact ? to : this.track.propsOf(this.after - 1);
    const before = exact ? next : this.slots[this.after - 1]!;
    return [...from].map(([name, pose]) => {
      const later = exact ? undefined : to.get(name);
      const at = [...(later ? between(pose, later, (place - before) / (next - before)) : pose)];
      return { name, position: at.slice(0, 3), rotation: at.slice(3) };
    });
  }
  /** The last pose that was received up to there. */
  index(place: number): number {
    this.seek(place);
    return this.slots[this.after]! - place <= AT ? this.after : Math.max(0, this.after - 1);
  }
  private seek(place: number): void {
    while (this.slots[this.after]! < place - AT && this.after + 1 < this.slots.length) ++this.after;
  }
}

/** One pose per frame: as received, or interpolated between its neighbors. */
export function* posesOn(grid: Grid, index: number, track: Track): Generator<Float32Array | Float64Array> {
  const reader = new TrackReader(track, grid.slots[index]!);
  for (let frame = 0; frame < grid.frames; ++frame) yield reader.at(grid.first + frame * grid.step);
}
