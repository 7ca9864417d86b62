// Addresses of this page: the options after '?', and the link for OBS. Pure; pinned by
// test/links.test.mjs.

/** One performer alone, as OBS shows it. */
export interface Alone {
  performer: string; // '': the first one that is live
  avatar: string; // name of a .vrm that this browser keeps; '': none
  background: string; // a CSS colour
  props?: boolean; // its props are shown, too
  framing?: Framing; // unset: the whole body
  mirror?: boolean; // as in a mirror
}

/** How much of the body is in the picture: head and shoulders, or down to the hips. */
export type Framing = 'bust' | 'half';
const FRAMINGS: readonly string[] = ['bust', 'half'] satisfies Framing[];

/** undefined: the whole page is requested. `isColor`: whether a browser knows that colour. */
export function aloneOf(search: string, isColor: (text: string) => boolean): Alone | undefined {
  const asked = new URLSearchParams(search);
  if (asked.get('view') !== 'avatar') return undefined;
  const text = asked.get('bg') ?? 'transparent';
  // '#' begins a fragment, so a colour is written without it.
  const background = [text, `#${text}`].find(isColor) ?? 'transparent';
  return { performer: asked.get('performer') ?? '', avatar: asked.get('avatar') ?? '', background,
           ...(asked.get('props') === '1' ? { props: true } : {}), ...(asked.get('mirror') === '1' ? { mirror: true } : {}),
           ...(FRAMINGS.includes(asked.get('frame') ?? '') ? { framing: asked.get('frame') as Framing } : {}) };
}

/** `page`: the address of this page; a `token` goes after '#', which browsers send to no server. */
export function obsLink(page: string, { performer, avatar, background, props, framing, mirror }: Alone, token?: string): string {
  const url = new URL('/', page);
  url.searchParams.set('view', 'avatar');
  url.searchParams.set('performer', performer);
  if (avatar) url.searchParams.set('avatar', avatar);
  url.searchParams.set('bg', background);
  if (framing) url.searchParams.set('frame', framing);
  if (mirror) url.searchParams.set('mirror', '1');
  if (props) url.searchParams.set('props', '1');
  if (token) url.hash = new URLSearchParams({ token }).toString();
  return url.href;
}

/** The whole page, as another device opens it. */
export function pageLink(page: string, token?: string): string {
  const url = new URL('/', page);
  if (token) url.hash = new URLSearchParams({ token }).toString();
  return url.href;
}

/** Whether only this machine reaches that address. */
export function isOwnMachine(page: string): boolean {
  return /^(localhost|.*\.localhost|127(\.\d+){3}|\[::1\])$/.test(new URL(page).hostname);
}
