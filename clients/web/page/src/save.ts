import { h } from './dom.js';

/** Milliseconds of work on a file, after which the event loop runs. */
export const AT_ONCE_MS = 40;

const KEPT_MS = 60000; // long enough for any browser to begin saving

/** To be awaited often during long work: lets the event loop run now and then, so that the page stays
responsive. */
export function breather(): () => Promise<void> | undefined {
  let begun_ms = performance.now();
  return () => {
    // A hidden page gets timers only once per second, and need not stay responsive.
    if (globalThis.document?.hidden || performance.now() - begun_ms < AT_ONCE_MS) return undefined;
    return new Promise((resolve) => setTimeout(() => {
      begun_ms = performance.now();
      resolve();
    }));
  };
}

/** Passes a file to the browser to be saved. */
export function saveFile(blob: Blob, name: string): void {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), KEPT_MS);
}
