// Keyboard control.
import type { App } from './app.js';
import { STYLE_KEYS } from './cards.js';
import type { CuePanel } from './cues.js';
import { dialog, inDialog, type Dialog } from './dialog.js';
import { h } from './dom.js';
import type { RecordPanel } from './record.js';
import type { Looks } from './roster.js';
import type { Stage } from './stage.js';

const HELP: [string, string][] = [
  ['1 … 9, 0', 'set a style; with Shift the next ten'],
  ['B', 'bypass'],
  ['Esc', 'panic: all performers to bypass'],
  ['Ctrl+Z, U', 'undo: the former look, or a removed style'],
  ['Ctrl+Shift+Z, Ctrl+Y', 'redo: the sliders of the style by hand'],
  ['[ ]', 'strength down, up'],
  ['G', 'GO: the next cue'],
  ['N', 'another variation of the style'],
  ['L', 'learn a style from the selected performer'],
  ['/', 'find a style'],
  ['↑ ↓', 'select a performer'],
  ['R', 'record the selected one; again: stop and save'],
  ['E', 'set the selected one, or all'],
  ['V', 'side by side, or overlaid'],
  ['T, C', 'foot trails, contact marks'],
  ['A D W S', 'camera left, right, up, down'],
  ['Q, Z', 'camera closer, farther'],
  ['F', 'camera home'],
  ['?', 'this list'],
];

// Fields that take letters and digits.
const TEXT = new Set(['text', 'search', 'number']);

// Keys that a focused, closed select element handles; letters and digits belong to the page.
const LIST_KEYS = new Set(['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'Home', 'End', 'PageUp', 'PageDown', 'Enter', ' ']);

// Browsers without :open do not deliver the keys of an open list to the page, or offer no way to
// tell.
function isOpen(list: HTMLSelectElement): boolean {
  return CSS.supports('selector(:open)') && list.matches(':open');
}

// After a choice with the mouse, the list loses focus. A choice with the arrow keys may continue.
function letGo(): void {
  let byKey = false;
  addEventListener('pointerdown', () => (byKey = false), true);
  addEventListener('keydown', ({ key }) => (byKey = LIST_KEYS.has(key)), true);
  addEventListener('change', ({ target }) => {
    if (target instanceof HTMLSelectElement && !byKey) target.blur();
  });
}

export function keys(
  app: App, stage: Stage, looks: Looks, record: RecordPanel, cues: CuePanel, cancelLesson: () => boolean, redo: () => boolean,
): Dialog {
  const help = dialog('Keys', 'help',
    h('dl', {}, ...HELP.flatMap(([key, what]) => [h('dt', {}, key), h('dd', {}, what)])));
  const stronger = (step: number) => {
    const look = app.entry()?.look;
    if (!look) return;
    const next = Math.min(1.5, Math.max(0, Math.round(((look.strength ?? 1) + step) * 10) / 10));
    void app.set({ strength: next }, `strength ${Math.round(100 * next)} %`, 'strength');
    app.entry()!.look = { ...look, strength: next }; // until the daemon reports it
    app.changed();
  };
  // Like a click, if there is such a button now.
  const press = (button: string) => document.querySelector<HTMLElement>(button)?.click();
  const plain: Record<string, () => void> = {
    b: () => void app.clear(),
    '[': () => stronger(-0.1),
    ']': () => stronger(0.1),
    arrowup: () => app.selectNext(-1),
    arrowdown: () => app.selectNext(1),
    e: () => {
      app.everyone = !app.everyone;
      app.changed();
    },
    g: () => cues.go(),
    r: () => record.toggle(),
    u: () => void app.undoLast(),
    n: () => press('[data-vary=dice]'),
    l: () => press('[data-example=learn]'),
    '/': () => document.querySelector<HTMLElement>('.find:not([hidden]) .filter')?.focus(),
    v: () => looks.toggle('overlay'),
    t: () => looks.toggle('trails'),
    c: () => looks.toggle('contacts'),
    f: () => stage.home(),
    a: () => stage.turn(-0.12, 0),
    d: () => stage.turn(0.12, 0),
    w: () => stage.turn(0, 0.1),
    s: () => stage.turn(0, -0.1),
    q: () => stage.turn(0, 0, 0.9),
    z: () => stage.turn(0, 0, 1.1),
    '?': help.show,
  };
  letGo();
  addEventListener('keydown', (event) => {
    const at = event.target;
    if (inDialog()) {
      if (event.key === '?' && help.element.open) help.element.close();
      return;
    }
    const typing = at instanceof HTMLInputElement && TEXT.has(at.type);
    if ((event.ctrlKey || event.metaKey) && !event.shiftKey && !event.altKey && event.key.toLowerCase() === 'z' && !typing) {
      event.preventDefault();
      if (!event.repeat) void app.undoLast();
      return;
    }
    const again = event.key.toLowerCase() === (event.shiftKey ? 'z' : 'y');
    if ((event.ctrlKey || event.metaKey) && !event.altKey && again && !typing) {
      if (redo()) event.preventDefault();
      return;
    }
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === 'Escape') {
      if (event.target instanceof HTMLSelectElement && isOpen(event.target)) return; // it closes the list
      if (typing && at.type === 'search' && at.value !== '') return; // it is emptied
      else {
        cancelLesson();
        void app.panic();
      }
      return;
    }
    if (typing) return;
    if (at instanceof HTMLSelectElement && (isOpen(at) || LIST_KEYS.has(event.key))) return;
    if (at instanceof HTMLInputElement && event.key.startsWith('Arrow')) return;
    const digit = /^Digit(\d)$/.exec(event.code);
    if (digit) {
      const style = app.styles()[STYLE_KEYS.indexOf(digit[1]!) + (event.shiftKey ? 10 : 0)];
      if (style) void app.setStyle(style);
      return;
    }
    const action = plain[event.key.toLowerCase()];
    if (!action) return;
    event.preventDefault();
    if (/^[rg]$/i.test(event.key) && event.repeat) return; // key repeat would start and stop it, or run through the cues
    action();
  });
  return help;
}
