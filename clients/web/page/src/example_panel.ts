// "By example": a style from a dropped file, or from the performer's motion.
import { NoAnswerError, RefusedError } from 'styled-client';

import type { App } from './app.js';
import type { Cards } from './cards.js';
import { h, setText } from './dom.js';
import { fileFault, outcomeOf, type Examples, type Outcome } from './examples.js';
import { Course, type Phase } from './learn.js';
import { kindOf, nameFault, proposedName, replacedBy } from './names.js';
import { Ordinary } from './ordinary.js';

const TICK_MS = 50;

// The learning of a style, while it lasts.
interface Lesson {
  course: Course;
  performer: string;
  name: string;
  cancelled: boolean;
}

/** Over the stage: the countdown and the take, large enough for the performer. */
function bigScreen(cancel: () => void): { element: HTMLElement; show(phase: Phase | undefined, lesson?: Lesson): void } {
  const title = h('b', { role: 'status' }), number = h('strong', { 'aria-live': 'assertive' });
  const bar = h('progress', { max: 1, value: 0, 'aria-label': 'How much of the take is over' });
  const stop = h('button', { onclick: cancel }, 'Cancel');
  const element = h('div', { className: 'lesson', hidden: true, role: 'group', 'aria-label': 'Learning from the performer' },
    title, number, bar, stop);
  return {
    element,
    show(phase, lesson) {
      const on = phase !== undefined && phase.kind !== 'over' && lesson !== undefined;
      if (on && element.hidden) {
        element.hidden = false;
        stop.focus();
      }
      element.hidden = !on;
      if (!on) return;
      const neutral = phase.what === 'neutral';
      element.dataset.phase = phase.kind;
      element.dataset.what = phase.what;
      setText(title, phase.kind === 'wait' ? 'Thank you' : neutral ? `${lesson.performer}, move as usual`
        : `${lesson.performer}, act out ${lesson.name}`);
      setText(number, phase.kind === 'count' ? String(phase.left) : phase.kind === 'take' ? (neutral ? 'Neutral' : 'Go') : 'Making the style …');
      bar.value = phase.kind === 'take' ? phase.part : phase.kind === 'wait' ? 1 : 0;
    },
  };
}

interface Form {
  element: HTMLFormElement;
  open(kind: Ask): void;
  close(): void;
}

interface Take {
  seconds: number;
  neutral: boolean; // a neutral take comes first
  add: boolean; // the example is added to the style of that name
}

type Ask =
  | { kind: 'file'; file: File; name: string }
  | { kind: 'style'; file: File; name: string }
  | { kind: 'learn' };

// The made style that the selected performer wears, alone, or ''.
function chosenMade(app: App): string {
  const mix = (app.entry()?.look?.mix ?? []).filter(({ weight }) => weight > 0);
  return mix.length === 1 && app.info(mix[0]!.style)?.made ? mix[0]!.style : '';
}

const WIDTH = 84, HEIGHT = 80; // of a figure, in pixels of the page

// A new style's figure beside the neutral one's, where the weights have a neutral style.
function besideNeutral(app: App, cards: Cards): { element: HTMLElement; show(style: string | undefined): void } {
  const dense = Math.min(devicePixelRatio, 2);
  const parts = ['before', 'after'].map((className) => ({
    figure: cards.elsewhere(), words: h('figcaption', {}),
    canvas: h('canvas', { className, width: Math.round(WIDTH * dense), height: Math.round(HEIGHT * dense), 'aria-hidden': 'true' }),
  }));
  const element = h('div', { className: 'beside', hidden: true }, ...parts.map(({ canvas, words }) => h('figure', {}, canvas, words)));
  return {
    element,
    show(style) {
      const neutral = app.list?.styles.find((info) => info.neutral)?.name;
      element.hidden = style === undefined || neutral === undefined;
      [neutral, style].forEach((name, i) => {
        const { figure, words, canvas } = parts[i]!;
        setText(words, name ?? '');
        if (element.hidden) figure.show(undefined);
        else figure.show(name, canvas);
      });
    },
  };
}

// Asks for the name and the other options.
function nameForm(app: App, done: (name: string, ask: Ask, take: Take) => void): Form {
  const about = h('p', { className: 'hint' });
  const name = h('input', { type: 'text', name: 'style', maxLength: 40, spellcheck: false, autocomplete: 'off', 'aria-label': 'Name of the style' });
  const seconds = h('input', { type: 'number', name: 'seconds', min: '1', max: '60', step: '1', value: '8', 'aria-label': 'Seconds of the take' });
  const neutral = h('input', { type: 'checkbox', name: 'neutral' });
  const learning = h('div', { className: 'learning' },
    h('label', {}, seconds, ' seconds'),
    h('label', { title: 'First the performer moves as usual; only the difference is used' }, neutral, ' neutral take first'));
  const add = h('input', { type: 'checkbox', name: 'add' }), addWords = h('span', {});
  const adding = h('label', { title: 'The style is the mean of what both examples show, and has what only one shows' }, add, addWords);
  let addTo = ''; // the made style to which the example can be added
  let own = ''; // the name while nothing is added
  const remark = h('p', { className: 'hint', role: 'status' });
  const go = h('button', { type: 'submit', className: 'go' }, 'Make');
  let ask: Ask | undefined;
  const check = (): string => {
    const taken = app.taken(), fault = nameFault(name.value.trim(), taken);
    const replaced = add.checked ? '' : replacedBy(name.value.trim(), taken);
    if (!add.checked) addTo = ask?.kind === 'style' ? '' : replaced || chosenMade(app);
    adding.hidden = addTo === '';
    setText(addWords, ` add to ${addTo}`);
    setText(remark, fault || (replaced ? `Replaces ${replaced}. Undo brings it back.` : ''));
    remark.classList.toggle('bad', fault !== '');
    return fault;
  };
  const close = () => {
    element.hidden = true;
    ask = undefined;
  };
  name.addEventListener('input', check);
  add.addEventListener('change', () => {
    if (add.checked) own = name.value;
    name.value = add.checked ? addTo : own;
    name.readOnly = add.checked;
    check();
  });
  const element = h('form', {
    className: 'ask', hidden: true, noValidate: true,
    onsubmit: (event: Event) => {
      event.preventDefault();
      if (!ask) return;
      if (check()) return name.focus();
      const length = Number(seconds.value);
      if (ask.kind === 'learn' && !(length >= 1 && length <= 60)) {
        setText(remark, 'A take has 1 to 60 seconds.');
        remark.classList.add('bad');
        return seconds.focus();
      }
      const asked = ask;
      close();
      done(name.value.trim(), asked, { seconds: length, neutral: neutral.checked, add: add.checked });
    },
    onkeydown: (event: KeyboardEvent) => {
      if (event.key !== 'Escape') return;
      event.stopPropagation(); // Esc here closes the dialog instead of Panic
      close();
    },
  }, about, h('label', { className: 'named' }, 'Name', name), adding, learning, remark,
     h('div', { className: 'row' }, go, h('button', { type: 'button', onclick: close }, 'Cancel')));
  return {
    element,
    close,
    open(next) {
      ask = next;
      learning.hidden = next.kind !== 'learn';
      add.checked = name.readOnly = false;
      setText(go, next.kind === 'learn' ? 'Start' : next.kind === 'style' ? 'Import' : 'Make');
      setText(about, next.kind === 'learn' ? `${app.selected} acts the style out, after a countdown.` : next.file.name);
      name.value = next.kind === 'learn' ? proposedName('style', app.taken()) : next.name;
      element.hidden = false;
      check();
      element.scrollIntoView({ block: 'nearest' });
      name.focus();
      name.select();
    },
  };
}

export interface ExamplePanel {
  element: HTMLElement;
  /** Shown over the stage during a take. */
  lesson: HTMLElement;
  /** Accepts a dropped file; false if it is for another panel. */
  take(files: File[]): boolean;
  /** Cancels the current take; false if there is none. */
  cancel(): boolean;
}

export function examplePanel(app: App, examples: Examples, cards: Cards): ExamplePanel {
  let lesson: Lesson | undefined;
  let busy = false;
  const result = h('div', { className: 'result', role: 'status', tabIndex: 0, 'aria-label': 'The last example' }); // it may scroll
  const list = (className: string, title: string, lines: string[] = []) =>
    lines.length === 0 ? [] : [h('ul', { className, 'aria-label': title }, ...lines.map((line) => h('li', {}, line)))];
  let watched: Ordinary | undefined; // the style that was just made, on its wearer
  const beside = besideNeutral(app, cards);
  const ordinary = h('p', { className: 'weak', 'data-ordinary': '' }, 'This example is ordinary motion: nothing of it will be seen. Let the performer exaggerate.');
  app.client.on('stats', ({ performers }) => {
    const now = watched?.heard(performers);
    if (now !== undefined) ordinary.hidden = !now;
  });
  const say = ({ text, bad, found, weak }: Outcome, made?: { performer: string; name: string }) => {
    watched = made && new Ordinary(made.performer, made.name);
    ordinary.hidden = true;
    beside.show(bad ? undefined : made?.name);
    result.replaceChildren(h('p', {}, text), beside.element, ordinary, ...list('found', 'Found in the example', found), ...list('weak', 'Weak in the example', weak));
    result.classList.toggle('bad', bad);
    result.hidden = text === '';
  };
  say({ text: '', bad: false });
  const fail = (error: unknown) => {
    if (!(error instanceof RefusedError || error instanceof NoAnswerError)) throw error;
    const open = error instanceof NoAnswerError && error.sent ? '; the style may still come' : '';
    say({ text: `${error.message}${open}`, bad: true });
  };

  const cancel = (): boolean => {
    if (!lesson || lesson.cancelled) return false;
    lesson.cancelled = true;
    lesson.course.stop();
    screen.show(undefined);
    learn.focus();
    say({ text: `${lesson.name}: cancelled`, bad: false });
    paint();
    return true;
  };
  const screen = bigScreen(() => cancel());

  // Waits for the countdown; false if it is cancelled.
  const counted = async (running: Lesson): Promise<boolean> => {
    while (!running.cancelled && !running.course.due(performance.now())) {
      await new Promise((resolve) => setTimeout(resolve, TICK_MS));
    }
    running.course.go(performance.now());
    return !running.cancelled;
  };
  const learnFrom = async (name: string, { seconds, neutral, add }: Take) => {
    const performer = app.selected, looks = app.looks(performer);
    const running: Lesson = { course: new Course(seconds, neutral, performance.now()), performer, name, cancelled: false };
    lesson = running;
    say({ text: '', bad: false });
    const timer = setInterval(() => screen.show(running.cancelled ? undefined : running.course.at(performance.now()), running), TICK_MS);
    try {
      const back = await examples.former(name);
      let neutralCode: number[] = [];
      if (neutral) {
        if (!(await counted(running))) return;
        neutralCode = (await app.client.like(performer, { measure: true, learnS: seconds })).code;
        running.course.done(performance.now());
      }
      if (!(await counted(running))) return;
      const reply = await app.client.like(performer, { name, learnS: seconds, neutralCode, add, transitionMs: app.transition_ms });
      if (running.cancelled) { // too late for the daemon: it is undone
        await app.fetchLooks();
        await app.restore(looks);
        return await back();
      }
      examples.made(name, looks, back);
      say(outcomeOf(reply, performer, performer, add), { performer, name });
    } catch (error) {
      if (!running.cancelled) fail(error);
    } finally {
      clearInterval(timer);
      running.course.stop();
      screen.show(undefined);
      lesson = undefined;
      await app.refresh();
    }
  };

  const form = nameForm(app, (name, ask, take) => {
    if (ask.kind === 'learn') void learnFrom(name, take);
    else void send(name, ask.file, ask.kind, take.add);
    zone.focus();
  });
  // One after the other, so that the reply to the last file remains.
  let sent: Promise<void> = Promise.resolve();
  const send = (name: string, file: File, kind: 'file' | 'style', add = false): Promise<void> => {
    sent = sent.catch(() => undefined).then(() => sendNow(name, file, kind, add));
    return sent;
  };
  const sendNow = async (name: string, file: File, kind: 'file' | 'style', add: boolean) => {
    busy = true;
    say({ text: `${file.name}: reading …`, bad: false });
    paint();
    try {
      const bytes = new Uint8Array(await file.arrayBuffer());
      if (kind === 'style') say(await examples.add(name, bytes));
      else {
        const performer = app.selected;
        say(await examples.like(name, bytes, file.name, add), { performer, name });
      }
    } catch (error) {
      fail(error);
    }
    busy = false;
    paint();
  };
  const readStyle = async (file: File) => {
    let name = '';
    try {
      const { name: own } = JSON.parse(await file.text()) as { name?: unknown };
      if (typeof own === 'string') name = own;
    } catch {
      // the daemon reports the error
    }
    const taken = app.taken();
    if (name === '' || (nameFault(name, taken) === '' && !taken.made.has(name))) return send(name, file, 'style');
    form.open({ kind: 'style', file, name });
  };
  const take = (files: File[]): boolean => {
    const wanted = files.filter(({ name }) => ['example', 'style'].includes(kindOf(name)));
    const [first] = wanted;
    if (!first) return false;
    if (app.watchOnly) {
      app.onMessage('this gateway is for watching only', true);
      return true;
    }
    for (const file of wanted) {
      const fault = fileFault(file);
      if (fault) say({ text: fault, bad: true });
      else if (kindOf(file.name) === 'style') void readStyle(file);
      else if (file === first) form.open({ kind: 'file', file, name: proposedName(file.name, app.taken()) });
    }
    return true;
  };

  const chosen = h('input', { type: 'file', accept: '.bvh,.glb,.vrma,.json', hidden: true });
  chosen.addEventListener('change', () => {
    const [file] = chosen.files ?? [];
    if (file && !take([file])) app.onMessage(`${file.name}: expected .bvh, .glb or .vrma, or the .json of a style`, true);
    chosen.value = '';
  });
  const zone = h('button', { className: 'drop', 'data-example': 'file', onclick: () => chosen.click() }, 'Drop a clip, or choose …');
  const learn = h('button', { className: 'drop learn', 'data-example': 'learn', onclick: () => form.open({ kind: 'learn' }) }, 'Learn from performer …');
  const element = h('section', { className: 'examples' },
    h('h2', { title: 'A style of an example: .bvh, .glb, .vrma, or the .json of an exported style' }, 'Style by example'), zone, learn, chosen, form.element, result);
  const obstacle = () => {
    if (!app.client.daemonState.up) return 'The daemon is away.';
    if (lesson) return lesson.cancelled ? 'The cancelled take ends first.' : 'A take is in progress.';
    if (!app.entry()) return 'No performer is present.';
    return app.entry()!.live ? '' : `${app.selected} is silent.`;
  };
  const paint = () => {
    element.hidden = app.watchOnly;
    const reason = obstacle();
    learn.disabled = reason !== '';
    learn.title = reason || `${app.selected} acts out a style for some seconds`;
    zone.disabled = busy || !app.client.daemonState.up;
    zone.title = '.bvh, .glb or .vrma: an example motion; .json: an exported style';
  };
  app.watch(paint);
  paint();
  return { element, lesson: screen.element, take, cancel };
}
