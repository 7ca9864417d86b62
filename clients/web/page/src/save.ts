import { h } from './dom.js';

/** Of work on a file, then the event loop runs. */
export const AT_ONCE_MS = 40;

const KEPT_MS = 60000; // long enough for any browser to begin saving

/** Hands a file to the browser to be saved. */
export function saveFile(blob: Blob, name: string): void {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), KEPT_MS);
}
