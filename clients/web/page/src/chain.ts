// The way of a performer's frames as a row of links, from the rig to this page: each is in order, or states its cure.
// Pure; pinned by test/chain.test.mjs.
import { type PerformerStats, type SourceInfo, type Stats } from 'styled-client';

import { KNOWN, PHONES, SILENT, UNHEARD, reasonOf } from './findings.js';

export type State = 'ok' | 'warn' | 'bad' | 'off'; // off: not known, or not in use

export interface Link {
  name: 'Rig' | 'Port' | 'Body' | 'Neutral' | 'Style' | 'Reader';
  state: State;
  text: string;
}

// The source of a performer: their name begins with it. Without a performer, the one that receives most.
function sourceOf({ sources }: Stats, performer: string): SourceInfo | undefined {
  if (performer) {
    return sources.filter(({ name }) => performer === name || performer.startsWith(`${name}.`)).sort((a, b) => b.name.length - a.name.length)[0];
  }
  const own = sources.filter(({ type, mergeInto }) => !mergeInto && !PHONES.includes(type));
  return [...(own.length > 0 ? own : sources)].sort((a, b) => Number(b.received - a.received))[0];
}

function rigAndPort(source: SourceInfo | undefined, fresh: number, entry: PerformerStats | undefined): [Link, Link] {
  if (!source) {
    return [{ name: 'Rig', state: 'off', text: 'not known' },
            { name: 'Port', state: 'bad', text: 'No source is configured: the daemon needs a [[source]] with the address to which the rig sends.' }];
  }
  const { type, listen, received, kernelDropped } = source;
  const place = listen || `asks ${type}`;
  if (received === 0n) {
    return [{ name: 'Rig', state: 'off', text: `${type}: not heard yet` },
            { name: 'Port', state: 'bad', text: `${place}: ${SILENT[type] ?? UNHEARD}` }];
  }
  const rig: Link = entry?.live || fresh > 0
    ? { name: 'Rig', state: 'ok', text: entry?.live ? `${type}, ${entry.rateHz.toFixed(0)} frames a second` : `${type}, ${fresh} datagrams in the last second` }
    : { name: 'Rig', state: 'bad', text: `${type}: nothing arrives now. Is ${PHONES.includes(type) ? 'the app on the phone open and in front' : "the rig's application still sending"}?` };
  const port: Link = kernelDropped > 0n
    ? { name: 'Port', state: 'warn', text: `${place}: ${kernelDropped} datagrams found its buffer full` } : { name: 'Port', state: 'ok', text: place };
  return [rig, port];
}

function bodyOf(entry: PerformerStats | undefined, why: string | undefined, fresh: number): Link {
  const name = 'Body';
  if (entry?.live) return { name, state: entry.warning ? 'warn' : 'ok', text: entry.warning || `${entry.joints} joints, ${entry.dialect}` };
  if (fresh > 0) return { name, state: 'bad', text: `Data arrive, but no pose: ${why ?? 'stylectl doctor looks into them'}.` };
  return { name, state: 'off', text: entry && entry.joints > 0 ? `${entry.joints} joints, ${entry.dialect}` : 'not known yet' };
}

function neutralOf(entry: PerformerStats | undefined): Link {
  const name = 'Neutral', known = entry?.neutral;
  if (!entry || !known) return { name, state: 'off', text: entry ? 'These weights need none.' : 'not known yet' };
  if (known.calibratesS > 0) return { name, state: 'warn', text: `is being shown: ${Math.ceil(known.calibratesS)} s` };
  if (known.calibrated) return { name, state: 'ok', text: 'as it was shown' };
  const share = `learned ${Math.round(100 * known.learned)} %`;
  if (known.learned >= KNOWN) return { name, state: 'ok', text: share };
  return { name, state: 'warn', text: `${share}: stand and walk as usual, with the arms hanging, or press Learn walk` };
}

function styleOf(entry: PerformerStats | undefined): Link {
  const name = 'Style', look = entry?.look;
  if (!entry || !look) return { name, state: 'off', text: 'not known yet' };
  const set = look.mix.filter(({ weight }) => weight > 0).map(({ style }) => style).join(' + ');
  if (!set) return { name, state: 'off', text: 'bypass: choose a style' };
  if (look.strength === 0) return { name, state: 'warn', text: `${set}, at strength 0: raise it` };
  if (!entry.live) return { name, state: 'off', text: set };
  if (entry.overloadBypass) return { name, state: 'bad', text: `${set} is faded out: this machine is overloaded` };
  if (entry.hardlyStyled) return { name, state: 'warn', text: `${set} leaves this motion as it is: walk, or try another style` };
  const most = Math.max(0, ...(entry.moved ? [entry.moved.head, entry.moved.hands, entry.moved.elbows, entry.moved.knees, entry.moved.feet] : []));
  return { name, state: 'ok', text: entry.moved ? `${set}, moves a limb by ${most.toFixed(0)} cm` : set };
}

function readerOf(now: Stats, before: Stats | undefined, entry: PerformerStats | undefined, arrived: number | undefined): Link {
  const name = 'Reader';
  const grown = (counter: string) => {
    const of = (stats: Stats | undefined) => Number(stats?.counters.find((one) => one.name === counter)?.value ?? 0n);
    return before ? of(now) - of(before) : 0;
  };
  if (!entry?.live) return { name, state: 'off', text: 'This page reads; there is nothing to read.' };
  if (arrived === 0) return { name, state: 'bad', text: 'No frame reaches this page: is the network between the gateway and this browser slow?' };
  if (grown('publish.subscribers_stalled') > 0) return { name, state: 'warn', text: "A reader takes nothing: the daemon's log names its address" };
  if (grown('publish.canary_missed') > 0) return { name, state: 'warn', text: 'Readers miss frames: this machine is too busy' };
  const topics = Number(now.counters.find((one) => one.name === 'publish.subscriptions')?.value ?? 0n);
  return { name, state: 'ok', text: `this page${arrived === undefined ? '' : ` gets ${arrived} frames a second`}; ${topics} topics are read in all` };
}

/** `performer`: '' without a performer. `before`: the statistics of about a second earlier, and `arrived`: the
frames that reached this page since, if that is known. */
export function chainOf(now: Stats, before: Stats | undefined, performer: string, arrived: number | undefined): Link[] {
  const old = before?.epoch === now.epoch ? before : undefined;
  const entry = now.performers.find((one) => one.performer === performer);
  const source = sourceOf(now, performer);
  const had = old?.sources.find(({ name }) => name === source?.name);
  const fresh = source && had ? Number(source.received - had.received) : 0;
  return [...rigAndPort(source, fresh, entry), bodyOf(entry, old && reasonOf(now, old), fresh), neutralOf(entry), styleOf(entry),
          readerOf(now, old, entry, arrived)];
}
