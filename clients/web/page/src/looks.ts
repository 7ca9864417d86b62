// Looks of performers: the change that restores one, and the stored looks of several.
import type { Look, SetInit, Stats } from 'styled-client';

/** How a performer is set: a style, and whether it is pinned. */
export interface Setting {
  look: Look;
  pinned: boolean;
}

/** By performer. */
export function settingsOf(stats: Stats | undefined): Map<string, Setting> {
  return new Map((stats?.performers ?? []).flatMap(({ performer, look, pinned }) => (look ? [[performer, { look, pinned }] as const] : [])));
}

// The content of a look as text; fades are not part of it.
function textOf(look: Look): string {
  const { mix, strength, absolute, parts, inputStyle, root, vary, varyEach, varyAmount, driftS } = look;
  return JSON.stringify([mix.map(({ style, weight }) => [style, weight]), strength, absolute, [...parts].sort(), inputStyle,
                         root, vary, varyEach, varyAmount, driftS]);
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
  const { strength, absolute, parts, inputStyle, root, vary, varyEach, varyAmount, driftS } = look;
  const mix = look.mix.map(({ style, weight }) => ({ style, weight }));
  const whole: SetInit = { strength, absolute, parts: [...parts], inputStyle, root, vary, varyEach, varyAmount, driftS, transitionMs };
  // Only reported fields are sent: an older daemon refuses fields that it does not know.
  for (const [name, value] of Object.entries(whole)) {
    if (value === undefined) delete (whole as Record<string, unknown>)[name];
  }
  if (look.preset && presets.includes(look.preset)) return { ...whole, preset: look.preset };
  return mix.length === 0 ? { ...whole, clear: true } : { ...whole, mix };
}
