// Names of styles from examples.

const LONGEST = 32;
const ALLOWED = /^[A-Za-z0-9_-]{1,32}$/;
/** Words of stylectl and OSC with another meaning (daemon/styles/style_list.cpp). */
const RESERVED = ['all', 'bypass', 'clear', 'cue', 'design', 'each', 'error', 'learn', 'like', 'none', 'panic', 'pin', 'preset', 'reset', 'unpin', 'vary'];

/** Names in use: made styles may be replaced, others may not. */
export interface NamesInUse {
  made: ReadonlySet<string>;
  fixed: ReadonlySet<string>; // styles of the weights, their aliases, presets
}

const same = (names: ReadonlySet<string>, name: string) =>
  [...names].some((other) => other.toLowerCase() === name.toLowerCase());

/** A free name after a file's, without its folder and extension. */
export function proposedName(file: string, taken: NamesInUse): string {
  const stem = file.split(/[\\/]/).pop()!.replace(/\.[^.]*$/, '');
  const plain = stem.normalize('NFKD').replace(/[\u0300-\u036f]/g, '')
    .replace(/[^A-Za-z0-9_-]+/g, '-').replace(/^-+|-+$/g, '').slice(0, LONGEST) || 'style';
  const free = (name: string) => !same(taken.made, name) && !same(taken.fixed, name) && !RESERVED.includes(name.toLowerCase());
  for (let number = 1; ; ++number) {
    const tail = number === 1 ? '' : `-${number}`;
    const name = plain.slice(0, LONGEST - tail.length) + tail;
    if (free(name)) return name;
  }
}

/** Why a new style cannot have this name, in a sentence; '' if it can. */
export function nameFault(name: string, taken: NamesInUse): string {
  if (name === '') return 'The style needs a name.';
  if (name.length > LONGEST) return `A name has at most ${LONGEST} letters; this one has ${name.length}.`;
  if (!ALLOWED.test(name)) return 'A name has only letters A-Z a-z, digits, _ and -.';
  if (name.startsWith('-')) return 'A name does not begin with -.';
  if (RESERVED.includes(name.toLowerCase())) return `${name} is a word of stylectl with another meaning.`;
  return same(taken.fixed, name) ? `${name} is already a name of the weights or of a preset.` : '';
}

/** The style that a new one of this name would replace; '' if there is none. */
export function replacedBy(name: string, taken: NamesInUse): string {
  return taken.made.has(name) ? name : '';
}

export type Kind = 'avatar' | 'example' | 'style' | 'other';

/** The purpose of a dropped file, by its name. */
export function kindOf(file: string): Kind {
  const extension = /\.([^.]*)$/.exec(file)?.[1]?.toLowerCase() ?? '';
  if (extension === 'vrm') return 'avatar';
  if (['bvh', 'glb', 'vrma'].includes(extension)) return 'example';
  return extension === 'json' ? 'style' : 'other';
}
