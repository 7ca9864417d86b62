// Looks of performers: the change that restores one, and the stored looks of several.
import { LookSchema, type Look, type SetInit, type Stats } from 'styled-client';

/** How a performer is set: a style, and whether it is pinned. */
export interface Setting {
  look: Look;
  pinned: boolean;
}

/** By performer. */
export function settingsOf(stats: Stats | undefined): Map<string, Setting> {
  return new Map((stats?.performers ?? []).flatMap(({ performer, look, pinned }) => (look ? [[performer, { look, pinned }] as const] : [])));
}

// The fields of look.proto that are handled one by one here: a look's mix, the preset that the mix came from, its fade,
// and `clear`, which is a command. And all the others.
const APART = ['mix', 'preset', 'transitionMs', 'clear'] as const;
type Field = Exclude<keyof Look, (typeof APART)[number] | `$${string}`>;
const FIELDS = LookSchema.fields.map(({ localName }) => localName).filter((name): name is Field => !(APART as readonly string[]).includes(name));

// The content of a look as text, without fades.
function textOf(look: Look): string {
  const said = FIELDS.map((field) => (field === 'parts' ? [...look.parts].sort() : look[field]));
  return JSON.stringify([look.mix.map(({ style, weight }) => [style, weight]), ...said]);
}

export function sameLook(a: Look, b: Look): boolean {
  return textOf(a) === textOf(b);
}

/** The same look, whether pinned or not. */
export function sameSetting(a: Setting, b: Setting): boolean {
  return a.pinned === b.pinned && sameLook(a.look, b.look);
}

/** The change that leads to `look` from any other. A preset is set by name if it still exists. */
export function changeTo(look: Look, presets: readonly string[], transitionMs: number): SetInit {
  const mix = look.mix.map(({ style, weight }) => ({ style, weight }));
  // Only what the daemon reported is sent: an older one refuses fields that it does not know.
  const reported = FIELDS.filter((field) => look[field] !== undefined);
  const whole: SetInit = { transitionMs };
  for (const field of reported) Object.assign(whole, { [field]: look[field] });
  if (look.preset && presets.includes(look.preset)) return { ...whole, preset: look.preset };
  return mix.length === 0 ? { ...whole, clear: true } : { ...whole, mix };
}
