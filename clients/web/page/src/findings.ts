// Conclusions from the daemon's statistics about a silent rig, like the first checks of `stylectl
// doctor`. Pure; pinned by test/findings.test.mjs.
import { type PerformerStats, type Stats } from 'styled-client';

const MOST = 3; // sources
const OF_SOURCES = /^(source|pipeline)\./; // counters that datagrams of sources increase

// Descriptions of the counters of refused datagrams.
const REASONS: [RegExp, string][] = [
  [/bad_magic|bad_version|bad_kind|malformed|too_short|length_mismatch|bad_reserved/, 'they are not what this type of source understands: does the rig send another format, or to another port?'],
  [/bad_checksum/, 'they are damaged on the way, or no longer as the sender made them'],
  [/before_body/, 'no skeleton has arrived yet: restart the sender, or let it send the skeleton, too'],
  [/uncalibrated/, 'the performer is not calibrated: stylectl calibrate'],
  [/bodies_refused/, 'the skeleton is refused: stylectl status names the reason'],
  [/wrong_size|wrong_body/, 'they belong to another skeleton than the one sent before'],
  [/far_ahead|old_time|duplicate|reordered/, "their numbers or times are not those of the frames before: does a second sender send?"],
  [/second_sender|takeovers_refused/, 'a second sender uses the same name: only the first is used'],
  [/tcp_refused|tcp_silent|tcp_broken|tcp_cut_short/, 'the connection does not hold'],
  [/incomplete/, 'a phone sees no face, or parts of the frames are missing: does the network lose datagrams?'],
  [/rate_limited|table_full/, 'too much data: too many performers or frames'],
];

export const PHONES = ['livelinkface', 'ifacialmocap']; // a face: of another performer, or with a body of ours
// Why nothing arrives, by type of source; otherwise by transport.
export const SILENT: Record<string, string> = {
  ifacialmocap: 'the daemon asks the phone, which has never answered. Is its app open and in front, and does server of this source name its address?',
  natnet: "the daemon asks Motive, which has never answered. Does server of this source name Motive's machine, and is streaming on there?",
  livelinkface: 'nothing has ever arrived. Does the app on the phone name this machine and this port (Settings, Live Link), and does a firewall let it in?',
  usb: 'nothing has ever arrived. Is the device plugged in and switched on?',
  'slimevr-usb': 'nothing has ever arrived. Is the receiver plugged in, and are the trackers switched on?',
};
export const UNHEARD = 'nothing has ever arrived. Does the rig send to this machine and this port, and does a firewall let it in?';

// Counters are of the whole daemon, so this is valid for a source only while no other one sends.
export function reasonOf(now: Stats, before: Stats): string | undefined {
  const had = new Map(before.counters.map(({ name, value }) => [name, value]));
  const grown = now.counters.filter(({ name }) => OF_SOURCES.test(name))
    .map(({ name, value }) => ({ name, by: Number(value - (had.get(name) ?? 0n)) }))
    .filter(({ by }) => by > 0).sort((a, b) => b.by - a.by);
  for (const { name } of grown) {
    const found = REASONS.find(([pattern]) => pattern.test(name));
    if (found) return `${found[1]} (${name})`;
  }
  return undefined;
}

/** Sentences about the sources while no performer is live, the most helpful first. `before`: statistics
of about a second earlier, of the same daemon; without them only totals are used. */
export function findings(now: Stats, before: Stats | undefined): string[] {
  if (now.sources.length === 0) return ['No source is configured: the daemon needs a [[source]] with the address to which the rig sends.'];
  const old = before?.epoch === now.epoch ? before : undefined;
  const had = new Map(old?.sources.map(({ name, received }) => [name, received]));
  const freshOf = ({ name, received }: { name: string; received: bigint }) => Number(received - (had.get(name) ?? received));
  const only = now.sources.filter((source) => freshOf(source) > 0).length === 1;
  const layers = new Map(now.performers.flatMap(({ layers }) => layers.map(({ source, part }) => [source, part] as const)));
  const sentences = now.sources.map((source) => {
    const { name, type, listen, received, mergeInto } = source;
    const part = layers.get(name) ?? (PHONES.includes(type) && mergeInto ? 'face' : '');
    const place = `${name} (${type}${listen ? `, ${listen}` : ''})`;
    const fresh = freshOf(source);
    if (received === 0n) return { rank: 2, text: `${place}: ${SILENT[type] ?? UNHEARD}` };
    if (fresh === 0) return { rank: 1, text: `${place}: ${received} datagrams arrived, none of them now. Is ${PHONES.includes(type) ? 'the app on the phone open and in front' : "the rig's application still sending"}?` };
    const why = old && only ? reasonOf(now, old) : undefined;
    if (part && !why) return { rank: 3, text: `${place}: ${fresh} datagrams arrived in the last second: ${part === 'face' ? 'a face, which waits' : `${part}, which wait`} for the body of the performer that merge_into names.` };
    return { rank: 0, text: `${place}: ${fresh} datagrams arrived in the last second, but no pose: ${why ?? `stylectl doctor ${name} looks into them`}.` };
  });
  sentences.sort((a, b) => a.rank - b.rank);
  const more = sentences.length - MOST;
  return [...sentences.slice(0, MOST).map(({ text }) => text), ...(more > 0 ? [`${more} more ${more === 1 ? 'source' : 'sources'}: stylectl status.`] : [])];
}

/** Sentences about sources whose data, a face or fingers, reach no performer. */
export function strays(now: Stats): string[] {
  return now.sources.filter(({ stray }) => stray).map(({ name, type, stray }) => `${name} (${type}): ${stray}.`);
}

export const KNOWN = 0.8; // of a performer's neutral: two seconds of it

/** The state of a styled performer's neutral, after the style's name; '' if it is known well enough. */
export function neutralWords({ live, turnedDeg, neutral }: PerformerStats): string {
  if (!live || !neutral) return '';
  if (neutral.calibratesS > 0) return ` · shows their walk: ${Math.ceil(neutral.calibratesS)} s`;
  if (turnedDeg === undefined || neutral.calibrated || neutral.learned >= KNOWN) return '';
  return ` · learned ${Math.round(100 * neutral.learned)} %`;
}
