/** What a performer is published as. */
export type Stream =
  | 'rig' // styled, on the rig's own skeleton
  | 'canonical' // styled, on the canonical humanoid
  | 'source'; // as received, on the rig's own skeleton

export function frameTopic(performer: string, stream: Stream): string {
  return stream === 'source' ? `source/${performer}/` : `styled/${performer}/${stream}/`;
}

export type Parsed =
  | { kind: 'frame'; performer: string; stream: Stream }
  | { kind: 'body'; performer: string }
  | { kind: 'stats' };

/** Nothing where `topic` has another shape. */
export function parseTopic(topic: string): Parsed | undefined {
  if (topic === 'stats/') return { kind: 'stats' };
  const match = /^(styled|source|body)\/([^/]+)\/(?:(rig|canonical)\/)?$/.exec(topic);
  if (!match) return undefined;
  const [, what, performer, output] = match as unknown as [string, string, string, Stream?];
  if ((what === 'styled') !== (output !== undefined)) return undefined;
  if (what === 'body') return { kind: 'body', performer };
  return { kind: 'frame', performer, stream: what === 'source' ? 'source' : output! };
}
