// Converts a frame's facial expressions, by the names that the rig uses, to the expressions of an
// avatar. Names: VRM 1.0's presets, VRM 0's (Joy, Blink_L, A), ARKit's 52 (eyeBlinkLeft), and the
// avatar's own; upper and lower case are the same. Pure; pinned by test/expressions.test.mjs.

/** A value of 0 to 1 by name. */
export interface Named {
  name: string;
  value: number;
}

// VRM 0's names that are not VRM 1.0's in lower case.
const OF_VRM0: Record<string, string> = {
  joy: 'happy', sorrow: 'sad', fun: 'relaxed', a: 'aa', i: 'ih', u: 'ou', e: 'ee', o: 'oh',
  blink_l: 'blinkleft', blink_r: 'blinkright',
};

// VRM 1.0's presets.
const PRESETS = [
  'happy', 'angry', 'sad', 'relaxed', 'surprised', 'neutral', 'aa', 'ih', 'ou', 'ee', 'oh', 'blink', 'blinkLeft', 'blinkRight',
  'lookUp', 'lookDown', 'lookLeft', 'lookRight',
];

/** VRM 1.0's preset that a name means, of VRM 0 or 1.0 and in any case; undefined if it means none. */
export function presetOf(name: string): string | undefined {
  const low = name.toLowerCase();
  const meant = OF_VRM0[low] ?? low;
  return PRESETS.find((preset) => preset.toLowerCase() === meant);
}

// The presets that an avatar without ARKit's expressions shows instead. A preset, the ARKit names whose
// mean it is, and the value up to which it stays 0. Trackers exaggerate moods at rest, hence those
// values.
const OF_ARKIT: [string, string[], number][] = [
  ['blinkleft', ['eyeblinkleft'], 0],
  ['blinkright', ['eyeblinkright'], 0],
  ['aa', ['jawopen'], 0],
  ['ou', ['mouthpucker'], 0],
  ['oh', ['mouthfunnel'], 0],
  ['ee', ['mouthstretchleft', 'mouthstretchright'], 0],
  ['lookup', ['eyelookupleft', 'eyelookupright'], 0],
  ['lookdown', ['eyelookdownleft', 'eyelookdownright'], 0],
  ['lookleft', ['eyelookoutleft', 'eyelookinright'], 0],
  ['lookright', ['eyelookinleft', 'eyelookoutright'], 0],
  ['happy', ['mouthsmileleft', 'mouthsmileright'], 0.2],
  ['sad', ['mouthfrownleft', 'mouthfrownright'], 0.2],
  ['angry', ['browdownleft', 'browdownright'], 0.2],
  ['surprised', ['eyewideleft', 'eyewideright'], 0.2],
];
const VOWELS = ['aa', 'ih', 'ou', 'ee', 'oh'];
const LOOKS = ['lookup', 'lookdown', 'lookleft', 'lookright'];
const BLINKS = ['blink', 'blinkleft', 'blinkright'];
const MOODS = ['happy', 'sad', 'angry', 'surprised'];

// Presets, and the prefixes of ARKit's names for the same parts of the face: only one of both moves
// a part.
const PARTS: [string[], RegExp][] = [
  [BLINKS, /^eyeblink/],
  [VOWELS, /^(jaw|mouth|tongue)/],
  [LOOKS, /^eyelook/],
];

const clamped = (value: number) => (value > 0 ? Math.min(1, value) : 0); // 0 if it is not a number

// The values of ARKit's names as presets. Of several moods only the strongest is shown, because
// they contradict each other.
function presetsOf(face: Map<string, number>): Map<string, number> {
  const made = new Map<string, number>();
  for (const [preset, parts, from] of OF_ARKIT) {
    const mean = parts.reduce((sum, part) => sum + (face.get(part) ?? 0), 0) / parts.length;
    const value = Math.max(0, (mean - from) / (1 - from));
    if (value > 0) made.set(preset, value);
  }
  const strongest = Math.max(...MOODS.map((mood) => made.get(mood) ?? 0));
  let found = false;
  for (const mood of MOODS) {
    if (found || made.get(mood) !== strongest) made.delete(mood);
    else found = true;
  }
  return made;
}

// Both eyes' blink, or one for each, never both: their sum would close an eye twice.
function oneBlink(values: Map<string, number>, has: (name: string) => boolean): void {
  const both = values.get('blink') ?? 0;
  const left = Math.max(both, values.get('blinkleft') ?? 0), right = Math.max(both, values.get('blinkright') ?? 0);
  for (const name of BLINKS) values.delete(name);
  if (left === right && has('blink')) values.set('blink', left);
  else if (has('blinkleft') && has('blinkright')) values.set('blinkleft', left).set('blinkright', right);
  else if (has('blink')) values.set('blink', Math.min(left, right)); // the avatar cannot wink
}

/** The values of the avatar's expressions; those without a value in the frame are 0. `own`: the
names of the avatar's expressions, as it writes them. `eyes`: its eyes are turned by bones in this
frame, so expressions must not turn them, too. Names that match no expression of the avatar are left
out. */
export function expressionsOf(frame: Iterable<Named>, own: Iterable<string>, eyes = false): Map<string, number> {
  const written = new Map([...own].map((name) => [name.toLowerCase(), name]));
  const has = (name: string) => written.has(name);
  const values = new Map<string, number>(), face = new Map<string, number>();
  for (const { name, value } of frame) {
    const low = name.toLowerCase();
    const meant = has(low) ? low : OF_VRM0[low] ?? low;
    if (has(meant) || BLINKS.includes(meant)) values.set(meant, Math.max(values.get(meant) ?? 0, clamped(value)));
    else face.set(low, clamped(value));
  }
  for (const [preset, value] of presetsOf(face)) {
    if (has(preset) || BLINKS.includes(preset)) values.set(preset, Math.max(values.get(preset) ?? 0, value));
  }
  for (const [presets, part] of PARTS) {
    const moved = [...values].some(([name, value]) => part.test(name) && value > 0);
    if (moved || (eyes && presets === LOOKS)) for (const preset of presets) values.delete(preset);
  }
  oneBlink(values, has);
  const open = VOWELS.reduce((sum, vowel) => sum + (values.get(vowel) ?? 0), 0);
  if (open > 1) for (const vowel of VOWELS) if (has(vowel)) values.set(vowel, (values.get(vowel) ?? 0) / open);
  return new Map([...values].filter(([name, value]) => has(name) && value > 0).map(([name, value]) => [written.get(name)!, value]));
}
