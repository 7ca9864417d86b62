// Checks the arguments of StyledClient's calls. Each refusal names the value that was found and what was
// expected.
import { ScalarType, type MessageInitShape } from '@bufbuild/protobuf';

import { LookSchema } from './gen/proto/styled/v1/look_pb.js';

/** The fields that a change sets; the others stay. */
export type SetInit = MessageInitShape<typeof LookSchema>;

export function shown(value: unknown): string {
  return typeof value === 'string' ? JSON.stringify(value) : String(value);
}

export function checkOptions(options: { timeout_ms?: number; long_ms?: number }): void {
  if (typeof options !== 'object' || options === null) {
    throw new TypeError(`found ${shown(options)} as options, expected { url: 'http://127.0.0.1:7080' }`);
  }
  for (const name of ['timeout_ms', 'long_ms'] as const) {
    const value = options[name] ?? 1;
    if (typeof value !== 'number' || !(value > 0 && value < Infinity)) {
      throw new TypeError(`found ${shown(value)} as ${name}, expected milliseconds above 0`);
    }
  }
}

export function checkName(name: unknown, what: string): void {
  if (typeof name !== 'string' || name === '') throw new TypeError(`found ${shown(name)} as ${what}, expected a name`);
}

// The checks that TypeScript makes, for programs in JavaScript: protobuf would drop unknown fields.
export function checkChange(change: SetInit): void {
  if (typeof change !== 'object' || change === null) {
    throw new TypeError(`found ${shown(change)} as change, expected { strength: 0.5 } or the like`);
  }
  for (const [name, value] of Object.entries(change)) {
    if (name.startsWith('$') || value === undefined) continue;
    const field = LookSchema.fields.find(({ localName }) => localName === name);
    if (!field) {
      const names = LookSchema.fields.map(({ localName }) => localName).join(', ');
      throw new TypeError(`found "${name}" in the change, expected ${names}`);
    }
    const list = field.fieldKind === 'list';
    const kind = field.fieldKind !== 'scalar' ? 'number'
      : field.scalar === ScalarType.BOOL ? 'boolean' : field.scalar === ScalarType.STRING ? 'string' : 'number';
    if (list ? !Array.isArray(value) : typeof value !== kind) {
      throw new TypeError(`found ${shown(value)} as ${name}, expected a ${list ? 'list' : kind}`);
    }
  }
  for (const one of change.mix ?? []) {
    checkName(one?.style, 'style of mix');
    if (typeof one.weight !== 'number') throw new TypeError(`found ${shown(one.weight)} as weight of ${one.style}, expected a number`);
  }
}

const DESIGN = ['name', 'from', 'preset', 'sliders', 'transitionMs'];

export function checkDesign(design: object): void {
  if (typeof design !== 'object' || design === null) {
    throw new TypeError(`found ${shown(design)} as design, expected { sliders: { stoop: 28 } } or the like`);
  }
  for (const [name, value] of Object.entries(design)) {
    if (!DESIGN.includes(name)) throw new TypeError(`found "${name}" in the design, expected ${DESIGN.join(', ')}`);
    if (value === undefined) continue;
    const kind = name === 'sliders' ? 'object' : name === 'transitionMs' ? 'number' : 'string';
    if (typeof value !== kind || value === null) {
      const expected = kind === 'object' ? '{ stoop: 28 } or the like' : `a ${kind}`;
      throw new TypeError(`found ${shown(value)} as ${name} of the design, expected ${expected}`);
    }
    for (const [slider, number] of name === 'sliders' ? Object.entries(value) : []) {
      if (typeof number !== 'number') throw new TypeError(`found ${shown(number)} as slider ${slider}, expected a number`);
    }
  }
}
