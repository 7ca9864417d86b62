/** The streams in which a performer is published. */
export type Stream =
  | 'rig' // styled, on the rig's own skeleton
  | 'canonical' // styled, on the canonical humanoid
  | 'source'; // as received, on the rig's own skeleton

const STREAMS: readonly string[] = ['rig', 'canonical', 'source'] satisfies Stream[];
const PERFORMER = /^[A-Za-z0-9_-]{1,32}\.[A-Za-z0-9_-]{1,32}$/;
const A_PERFORMER = 'expected SOURCE.NAME, as in rig.anna, both 1 to 32 of A-Z a-z 0-9 _ -';

/** Throws a TypeError if `performer` is not SOURCE.NAME. */
export function checkPerformer(performer: string): void {
  if (typeof performer !== 'string' || !PERFORMER.test(performer)) {
    throw new TypeError(`found ${JSON.stringify(`${performer}`)} as performer, ${A_PERFORMER}`);
  }
}

/** The same, but also accepts "*", all performers. */
export function checkPerformers(performer: string): void {
  if (performer === '*') return;
  if (typeof performer !== 'string' || !PERFORMER.test(performer)) {
    throw new TypeError(`found ${JSON.stringify(`${performer}`)} as performer, ${A_PERFORMER}; or "*" for all`);
  }
}

/** Throws a TypeError if there is no such topic. */
export function frameTopic(performer: string, stream: Stream): string {
  checkPerformer(performer);
  if (!STREAMS.includes(stream)) {
    throw new TypeError(`found "${stream}" as stream, expected ${STREAMS.join(', ')}`);
  }
  return stream === 'source' ? `source/${performer}/` : `styled/${performer}/${stream}/`;
}

export type Parsed =
  | { kind: 'frame'; performer: string; stream: Stream }
  | { kind: 'body'; performer: string }
  | { kind: 'stats' };

/** Undefined if `topic` has another form. */
export function parseTopic(topic: string): Parsed | undefined {
  if (topic === 'stats/') return { kind: 'stats' };
  const match = /^(styled|source|body)\/([^/]+)\/(?:(rig|canonical)\/)?$/.exec(topic);
  if (!match) return undefined;
  const [, what, performer, output] = match as unknown as [string, string, string, Stream?];
  if ((what === 'styled') !== (output !== undefined)) return undefined;
  if (what === 'body') return { kind: 'body', performer };
  return { kind: 'frame', performer, stream: what === 'source' ? 'source' : output! };
}
