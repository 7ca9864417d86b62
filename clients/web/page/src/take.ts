// What a recording holds: poses as they came, and the even grid of time that a BVH file wants them on.
import type { Body, Frame } from 'styled-client';

const PIECE = 256; // poses kept in one array
const MOMENT = 4; // numbers that say when a pose was
const DISAGREE_S = 0.5; // between two clocks, over one step: the rig's began anew
const FORGET = 0.9; // of what a pose is early or late, the share that the next one is told
const SAME_RATE = 4e-4;

/** The poses of one stream, in order. A pose: 3 of the root, then 4 (x, y, z, w) per joint. */
export class Track {
  readonly width: number;
  length = 0;
  /** Frames that the daemon published and that did not get here, by their sequence. */
  missed = 0;
  private readonly poses: Float32Array[] = [];
  // MOMENT of each: sequence, seconds of the rig, of the daemon, the rig's own sequence
  private readonly moments: Float64Array[] = [];

  constructor(joints: number) {
    this.width = 3 + 4 * joints;
  }

  get bytes(): number {
    return this.poses.length * PIECE * (4 * this.width + 8 * MOMENT);
  }

  /** False where it is not newer than the last. */
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
      [sequence, seconds(frame.sourceTimeNs), seconds(frame.receiveTimeNs), Number(frame.sourceSequence)], MOMENT * at);
    ++this.length;
    return true;
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
}

/** Where every pose of the tracks stands in even steps of 1/rate_hz, and the steps that all have. */
export interface Grid {
  rate_hz: number;
  first: number;
  frames: number;
  /** Of each track, of each pose. */
  slots: number[][];
}

interface Moment {
  sequence: number;
  rig_s: number;
  daemon_s: number;
}

// Of all tracks, each sequence once: the same one has the same times everywhere.
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

// By the rig's clock, which has no network in it; by the daemon's where the rig's stands or jumps.
function step_s(a: Moment, b: Moment): number {
  const rig = b.rig_s - a.rig_s, daemon = b.daemon_s - a.daemon_s;
  return rig > 0 && Math.abs(rig - daemon) < DISAGREE_S ? rig : Math.max(0, daemon);
}

// "120" for 119.998: a whole rate, or one of NTSC's, where over all `steps` that makes less than half a
// step of difference. Otherwise as it is: a file's time is to be true to its end.
function rateMeant(rate_hz: number, steps: number): number {
  const ntsc_hz = (Math.round(rate_hz * 1.001) * 1000) / 1001;
  for (const meant_hz of [Math.round(rate_hz), ntsc_hz]) {
    const apart = Math.abs(rate_hz / meant_hz - 1);
    if (meant_hz >= 1 && apart < SAME_RATE && apart * steps < 0.5) return meant_hz;
  }
  return rate_hz;
}

/**
 * The grid of tracks of one take; undefined where there are not two poses. The step is the median one;
 * every pose has a step of its own, and as many are left free before it as time, or the sequence, says.
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
    // A pose that jitters is early or late once; the next one is measured from where it should have been.
    late_s = FORGET * (step + late_s - steps * usual_s);
    slot += steps;
    whole_s += step;
    slotOf.set(moments[i + 1]!.sequence, slot);
  });
  const slots = tracks.map((track) =>
    Array.from({ length: track.length }, (_, i) => slotOf.get(track.sequence(i))!));
  const first = Math.max(...slots.map((of) => of[0]!));
  const last = Math.min(...slots.map((of) => of.at(-1)!));
  return { rate_hz: rateMeant(slot / whole_s, slot), first, frames: Math.max(0, last - first + 1), slots };
}

/** How many steps of the grid have no pose of the track. */
export function filledIn(grid: Grid, track: number): number {
  const { first, frames } = grid;
  return frames - grid.slots[track]!.filter((slot) => slot >= first && slot < first + frames).length;
}

/** Of the steps that have no pose, how many by what is known of them. */
export interface Causes {
  /** The daemon published them: its sequence has a gap. */
  unreached: number;
  /** The rig numbered them, and the daemon published none. */
  unpublished: number;
  /** Neither: time passed, and no number is missing. */
  unnumbered: number;
}

export function causesOf(grid: Grid, index: number, track: Track): Causes {
  const slots = grid.slots[index]!;
  const steps = slots.slice(1).map((_, i) => ({
    slots: [slots[i]!, slots[i + 1]!] as const,
    published: track.sequence(i + 1) - track.sequence(i),
    numbered: track.sourceSequence(i + 1) - track.sourceSequence(i),
  }));
  // A rig of several performers may number the frames of all in one row.
  const each = steps.map(({ published, numbered }) => numbered / published).sort((a, b) => a - b);
  const usual = each[Math.floor(each.length / 2)] ?? 0;
  const causes: Causes = { unreached: 0, unpublished: 0, unnumbered: 0 };
  for (const { slots: [from, to], published, numbered } of steps) {
    const free = Math.min(to, grid.first + grid.frames) - Math.max(from, grid.first - 1) - 1;
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

/** `causes` in words; '' where nothing was filled in. */
export function causesInWords({ unreached, unpublished, unnumbered }: Causes): string {
  return [
    unreached && `${unreached} did not reach this page`,
    unpublished && `${unpublished} never left the daemon: lost on the way from the rig, or passed over because ` +
      'they came too late',
    unnumbered && `${unnumbered} where time passed between two frames of the rig in a row`,
  ].filter((part) => part).join('; ');
}

// The pose at `share` of the way from a to b: straight for the root, the shorter arc for joints.
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

/** One pose per step of the grid: as it came, or interpolated between its neighbors. */
export function* posesOn(grid: Grid, index: number, track: Track): Generator<Float32Array | Float64Array> {
  const slots = grid.slots[index]!;
  let after = 0;
  for (let slot = grid.first; slot < grid.first + grid.frames; ++slot) {
    while (slots[after]! < slot) ++after;
    const next = slots[after]!;
    if (next === slot) yield track.pose(after);
    else {
      const before = slots[after - 1]!;
      yield between(track.pose(after - 1), track.pose(after), (slot - before) / (next - before));
    }
  }
}
