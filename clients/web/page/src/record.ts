// The record button: its text, and the files that it saves.
import type { App } from './app.js';
import type { Avatar } from './avatar.js';
import { avatarGlb } from './avatar_glb.js';
import { bvhText } from './bvh.js';
import { h, setText } from './dom.js';
import { Film } from './film.js';
import { Recorder, type Ended } from './recorder.js';
import { breather, saveFile } from './save.js';
import type { Video } from './render.js';
import { Replay } from './replay.js';
import { causesInWords, causesOf, filledIn, gridOf, posesOn, type Grid, type Take } from './take.js';
import type { Stage } from './stage.js';
import { vrmaOf } from './vrma.js';

const WIDTH = 1920, HEIGHT = 1080, PICTURES_HZ = 60; // of a video
const LONGEST_S = 600; // the file is made in memory

const KINDS = ['styled', 'input', 'vrma', 'avatar', 'video', 'alone'] as const;
type What = (typeof KINDS)[number];
type Drawn = 'video' | 'alone'; // of these, what is drawn: the stage, and the body alone on a transparent ground

/** Videos are made from the recorded poses; without WebCodecs, as on pages without TLS, the stage is filmed.
*/
const RENDERS = 'VideoEncoder' in globalThis;

/** Why recording is not possible, or ''. */
function obstacle(app: App): string {
  if (app.client.linkState.kind !== 'open') return 'The gateway is away.';
  if (!app.client.daemonState.up) return 'The daemon is away.';
  const entry = app.entry();
  if (!entry) return 'No performer is present yet.';
  return entry.live ? '' : `${app.selected} is silent.`;
}

async function written(pieces: Iterable<string>): Promise<Blob> {
  const parts: string[] = [];
  const breathe = breather();
  for (const piece of pieces) {
    parts.push(piece);
    await breathe();
  }
  return new Blob(parts, { type: 'text/plain' });
}

const clock = (seconds: number) =>
  `${Math.floor(seconds / 60)}:${(seconds % 60).toFixed(1).padStart(4, '0')}`;

function stamp(time: Date): string {
  const two = (value: number) => String(value).padStart(2, '0');
  return `${time.getFullYear()}${two(time.getMonth() + 1)}${two(time.getDate())}` +
    `-${two(time.getHours())}${two(time.getMinutes())}${two(time.getSeconds())}`;
}

/** A take that has ended; it can be saved repeatedly. `film`: the filmed stage, if it was filmed. `avatar`: the
avatar that was worn. */
class Result {
  readonly filled: number[];
  private readonly humanoid: boolean; // it has the canonical humanoid
  private readonly videos = new Map<What, Video>();

  constructor(readonly take: Take, readonly grid: Grid, readonly film: Blob | undefined, readonly avatar: Avatar | undefined) {
    this.filled = [0, 1].map((track) => filledIn(grid, track));
    this.humanoid = Replay.of(take, grid)?.canonical !== undefined;
  }

  has(what: What): boolean {
    if (what === 'vrma') return this.humanoid;
    if (what === 'avatar') return this.humanoid && this.avatar !== undefined;
    if (what === 'alone') return RENDERS;
    return what !== 'video' || RENDERS || this.film !== undefined;
  }
  lacks(what: What): what is Drawn {
    return (what === 'video' || what === 'alone') && RENDERS && !this.videos.has(what);
  }

  /** False: `progress` returned false. */
  async render(what: Drawn, stage: Stage, progress: (share: number) => boolean): Promise<boolean> {
    const replay = Replay.of(this.take, this.grid);
    const filming = replay && stage.beginFilm(this.take.performer, WIDTH, HEIGHT, what === 'alone');
    if (!filming) throw new Error(`${this.take.performer} is no longer on the stage`);
    try {
      const { render } = await import('./render.js');
      const pictures = Math.max(1, Math.round(Math.min(LONGEST_S, replay.duration_s) * PICTURES_HZ));
      const video = await render(filming.canvas, PICTURES_HZ, pictures, (i) =>
        filming.draw((stream) => replay.at(stream, i / PICTURES_HZ), i === 0 ? 0.001 : 1 / PICTURES_HZ), progress, what === 'alone');
      if (video) this.videos.set(what, video);
    } finally {
      filming.end();
    }
    return this.videos.has(what);
  }

  words(): string {
    const { frames, rate_hz, step } = this.grid;
    const [source, styled] = this.filled as [number, number];
    const parts = [this.take.performer, `${(frames / rate_hz).toFixed(2)} s`,
                   `${frames} frames at ${Number(rate_hz.toFixed(3))} Hz`];
    if (Math.abs(step - 1) > 1e-9) parts.push(`the rig's own rate was ${(rate_hz * step).toFixed(2)} Hz`);
    const [video] = this.videos.values(); // all have the same pictures
    if (video) {
      const { pictures } = video;
      parts.push(`video of ${pictures} pictures at ${PICTURES_HZ} Hz` + (pictures / PICTURES_HZ >= LONGEST_S ? ', its first 10 minutes' : ''));
    }
    const filled = Math.max(source, styled);
    if (filled > 0) {
      const why = source > styled ? causesOf(this.grid, 0, this.take.source) : causesOf(this.grid, 1, this.take.styled);
      parts.push(`${filled} of them interpolated between their neighbours (${causesInWords(why)})`);
    }
    return parts.join(', ');
  }

  name(what: What): string {
    const whose = `${this.take.performer.replace(/[^\w.-]/g, '_')}-${what}-${stamp(this.take.begun)}`;
    if (what === 'alone' || (what === 'video' && RENDERS)) return `${whose}${this.lacks(what) ? '' : `.${this.videos.get(what)!.extension}`}`;
    if (what === 'video') return `${whose}.${Film.extension}`;
    const [track, extension] = ({ styled: ['rig', 'bvh'], input: ['source', 'bvh'], vrma: ['canonical', 'vrma'], avatar: ['canonical', 'glb'] } as const)[what];
    const filled = track === 'canonical' ? Replay.of(this.take, this.grid)!.filled(track) : this.filled[track === 'source' ? 0 : 1]!;
    return `${whose}${filled > 0 ? `-${filled}filled` : ''}.${extension}`;
  }

  async save(what: What): Promise<string> {
    const { take, grid } = this;
    const name = this.name(what);
    if (what === 'video' || what === 'alone') saveFile(this.videos.get(what)?.blob ?? this.film!, name);
    else if (what === 'vrma') saveFile(await vrmaOf(Replay.of(take, grid)!), name);
    else if (what === 'avatar') saveFile(await avatarGlb(Replay.of(take, grid)!, this.avatar!), name);
    else {
      const [index, track] = what === 'input' ? [0, take.source] as const : [1, take.styled] as const;
      saveFile(await written(bvhText(take.body, grid.rate_hz, grid.frames, posesOn(grid, index, track))), name);
    }
    return name;
  }
}

function resultOf(take: Take | undefined, film: Blob | undefined, avatar: Avatar | undefined): Result | undefined {
  const grid = take && gridOf([take.source, take.styled]);
  return grid && grid.frames > 1 ? new Result(take, grid, film, avatar) : undefined;
}

/** The text of a button that saves it again. */
function chipWords(what: What, name: string): string {
  const extension = /\.\w+$/.exec(name)?.[0] ?? (what === 'alone' ? 'film' : '1080p60');
  return what === 'vrma' ? extension : `${what[0]!.toUpperCase()}${what.slice(1)} ${extension}`;
}

export interface RecordPanel {
  element: HTMLElement;
  /** Shown over the stage during recording. */
  badge: HTMLElement;
  recorder: Recorder;
  toggle(): void;
}

export function recordPanel(app: App, stage: Stage): RecordPanel {
  const recorder = new Recorder(app.client);
  let film: Film | undefined;
  let result: Result | undefined;

  const label = h('span', {});
  const button = h('button', { className: 'record', onclick: () => toggle() },
    h('i', {}), label, h('kbd', {}, 'R'));
  const worn = h('option', { value: 'avatar' }, 'Avatar that moves, glTF');
  const choice = h('select', { 'aria-label': 'Formats to save' },
    h('option', { value: 'styled' }, 'Styled motion, BVH'),
    h('option', { value: 'styled input' }, 'Styled and input, 2 BVH'),
    h('option', { value: 'vrma' }, 'VRM animation, VRMA'),
    worn,
    h('option', { value: 'video', disabled: !RENDERS && !Film.extension,
                  title: RENDERS || Film.extension ? '' : 'This browser cannot record a picture' },
      RENDERS ? 'Video, 1080p60' : 'Video of the stage, as drawn'),
    h('option', { value: 'alone', disabled: !RENDERS, title: RENDERS ? 'WebM with alpha, for a video editor, OBS or a web page' : 'It needs WebCodecs: https, or localhost' },
      'Body or avatar alone, transparent video'));
  const line = h('p', { className: 'hint' });
  const chips = h('div', { className: 'chips' });
  const badge = h('div', { className: 'badge', hidden: true }, h('i', {}), h('span', {}));

  let rendering: { what: Drawn; share: number; cancelled: boolean } | undefined;
  // False: it was cancelled.
  const rendered = async (what: Drawn, of: Result): Promise<boolean> => {
    const now = rendering = { what, share: 0, cancelled: false };
    paint();
    try {
      return await of.render(what, stage, (share) => {
        now.share = share;
        paint();
        return !now.cancelled;
      });
    } finally {
      rendering = undefined;
      paint();
    }
  };
  const saveAll = async (what: What[], of: Result) => {
    try {
      const names: string[] = [];
      for (const one of what) {
        if (of.lacks(one) && !(await rendered(one, of))) continue;
        names.push(await of.save(one));
      }
      paintChips();
      return names.join(' and ');
    } catch (error) {
      app.onMessage(`cannot save: ${(error as Error).message}`, true);
      return '';
    }
  };
  const paintChips = () => {
    chips.replaceChildren(...KINDS.filter((what) => result?.has(what)).map((what) =>
        h('button', {
          'data-save': what, title: `Save ${result!.name(what)}`,
          onclick: () => void (rendering || saveAll([what], result!)),
        }, chipWords(what, result!.name(what)))));
  };

  const ended = async ({ take, reason }: Ended) => {
    const wanted = choice.value.split(' ') as What[];
    const ending = film;
    film = undefined;
    stage.steady = false;
    const filmed = await ending?.end();
    result = resultOf(take, filmed, stage.performers.get(take?.performer ?? '')?.avatar);
    paint();
    paintChips();
    const why = reason ? `Recording ended: ${reason}. ` : '';
    if (!result) {
      setText(line, `${why}Too short, nothing to save.`);
      return app.onMessage(line.textContent!, true);
    }
    const words = result.words();
    setText(line, `${why}${words}.`);
    const saving = result;
    const names = await saveAll(wanted.filter((what) => saving.has(what)), saving);
    setText(line, `${why}${saving.words()}.`);
    const lacking = wanted.find((what) => !saving.has(what));
    if (names) app.onMessage(`${why}Saved ${names}: ${saving.words()}.`, reason !== '');
    else if (lacking) {
      app.onMessage(`${why}${saving.has('vrma') ? `${saving.take.performer} wears no avatar` : 'No frame of the canonical humanoid arrived'}: ` +
        'nothing is saved yet; the buttons below save the recorded data.', true);
    }
  };
  recorder.onEnd = (how) => void ended(how);

  const toggle = () => {
    if (rendering) return void (rendering.cancelled = true);
    if (recorder.recording) return recorder.stop();
    const reason = obstacle(app);
    if (reason) return app.onMessage(`nothing to record: ${reason}`, true);
    result = undefined;
    paintChips();
    if (choice.value === 'video' && !RENDERS) {
      try {
        film = new Film(stage.canvas, (why) => recorder.stop(why));
      } catch (error) {
        return app.onMessage(`this browser cannot film the stage: ${(error as Error).message}`, true);
      }
      stage.steady = true;
    }
    recorder.start(app.selected);
    app.onMessage(`recording ${app.selected}`, false);
    paint();
  };

  const paint = () => {
    const on = recorder.recording;
    const reason = on || rendering ? '' : obstacle(app);
    button.disabled = reason !== '';
    button.title = rendering ? 'Cancel the video (R)' : on ? 'Stop and save (R)' : reason || `Record ${app.selected} (R)`;
    button.setAttribute('aria-pressed', String(on));
    choice.disabled = on || rendering !== undefined;
    worn.disabled = stage.performers.get(app.selected)?.avatar === undefined;
    worn.title = worn.disabled ? `${app.selected || 'No performer'} wears no avatar` : '';
    badge.hidden = !on && !rendering;
    const time = clock(recorder.elapsed_s);
    const done = rendering && `${Math.floor(100 * rendering.share)} %`;
    setText(label, done ? `Cancel · ${done}` : on ? `Stop · ${time}` : 'Record');
    document.title = on ? `● ${time} Styled` : 'Styled';
    if (done) {
      setText(badge.lastElementChild!, `video · ${done}`);
      setText(line, `The video is drawn from the recording; the stage ${rendering!.what === 'alone' ? 'stands meanwhile' : 'shows it'}, the daemon continues.`);
    } else if (on) {
      const missed = recorder.missed;
      setText(badge.lastElementChild!, `${recorder.performer} · ${time}`);
      setText(line, `${recorder.frames} frames${missed > 0 ? `, ${missed} did not reach this page` : ''}`);
      line.title = missed > 0 ? 'By the numbers of the frames that the daemon published: lost after it, or skipped ' +
        'because this page did not read. They are interpolated between their neighbours' : '';
    } else if (!result && reason) setText(line, `Nothing to record: ${reason}`);
    else if (!result && line.textContent!.startsWith('Nothing to record')) setText(line, '');
  };
  app.watch(paint);
  setInterval(() => recorder.recording && paint(), 100);
  addEventListener('beforeunload', (event) => {
    if (recorder.recording || rendering) event.preventDefault();
  });
  paint();
  return {
    element: h('section', { className: 'recording' }, h('h2', {}, 'Record'), button, choice, line, chips),
    badge, recorder, toggle,
  };
}
