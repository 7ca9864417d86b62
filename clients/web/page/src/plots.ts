// The strip below: the daemon's measurements of the selected performer, once per second.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

import type { App } from './app.js';
import { h, setText } from './dom.js';
import { lightScheme, schemeColor } from './scheme.js';

const SECONDS = 120;
const SILENT_MS = 3500; // statistics come once per second

interface Line {
  label: string;
  color: string; // its name in style.css
  fill?: string;
}

class Plot {
  readonly element: HTMLElement;
  private readonly plot: uPlot;
  private readonly data: (number | null)[][];
  private readonly now = h('output', {});
  private readonly beyond = h('span', { className: 'beyond', hidden: true });

  /** `cut`: values of the first line far above the second are clipped, and shown as a number. `limit`: the axis
  ends there at the latest. */
  constructor(title: string, lines: Line[], private readonly words: (values: number[]) => string,
              private readonly least: number, private readonly cut?: (most: number) => string,
              private readonly limit = () => Infinity) {
    this.data = [[], ...lines.map(() => [])];
    const box = h('div', { className: 'canvas' }, this.beyond);
    const legend = lines.length > 1
      ? h('span', { className: 'legend' }, ...lines.map(({ label, color }) => {
        const mark = h('b', {}, label);
        mark.style.color = `var(${color})`;
        return mark;
      })) : undefined;
    this.element = h('figure', { className: 'plot', title: lines.map(({ label }) => label).join(', ') },
      h('figcaption', {}, h('span', {}, title), legend, this.now), box);
    const axis = { stroke: () => schemeColor('--faint'), font: '10px system-ui', ticks: { show: false } };
    this.plot = new uPlot({
      width: 300, height: 78, cursor: { show: false }, legend: { show: false }, padding: [6, 4, 8, 0],
      scales: { x: { time: false, range: (_u, _min, max) => [max - SECONDS, max] },
                y: { range: () => [0, this.top()] } },
      axes: [{ ...axis, show: false },
             { ...axis, size: 38, splits: (_u, _i, min, max) => [min, (min + max) / 2, max],
               values: (_u, ticks) => ticks.map((tick) => tick >= 1000 ? `${(tick / 1000).toFixed(1)}k` : tick.toFixed(tick >= 10 || tick === 0 ? 0 : tick >= 1 ? 1 : 2)),
               grid: { stroke: () => schemeColor('--plot-grid'), width: 1 } }],
      series: [{}, ...lines.map(({ label, color, fill }) => ({
        label, stroke: () => schemeColor(color), width: 1.5, points: { show: false }, ...(fill ? { fill } : {}) }))],
    }, this.data as uPlot.AlignedData, box);
    lightScheme.addEventListener('change', () => this.plot.redraw());
    new ResizeObserver(() => {
      if (box.clientWidth > 0) this.plot.setSize({ width: box.clientWidth, height: box.clientHeight });
    }).observe(box);
  }

  add(time_s: number, values: (number | null)[]): void {
    this.data[0]!.push(time_s);
    values.forEach((value, i) => this.data[i + 1]!.push(value));
    while (this.data[0]!.length > SECONDS + 2) for (const row of this.data) row.shift();
    this.plot.setData(this.data as uPlot.AlignedData);
    const most = this.most(0);
    this.beyond.hidden = !this.cut || most <= this.top();
    if (this.cut) setText(this.beyond, this.cut(most));
    const known = values.every((value) => value !== null);
    setText(this.now, known ? this.words(values as number[]) : 'away');
    this.element.classList.toggle('quiet', !known);
    this.element.classList.remove('nodata');
  }

  /** The shown data is old: nothing arrives any more. */
  grey(): void {
    this.beyond.hidden = true;
    setText(this.now, 'no data');
    this.element.classList.add('quiet', 'nodata');
  }

  clear(): void {
    for (const row of this.data) row.length = 0;
  }

  private most(line: number): number {
    return Math.max(0, ...this.data[line + 1]!.map((value) => value ?? 0));
  }
  private top(): number {
    const most = this.cut ? 1.2 * this.most(1) : 1.12 * Math.max(...this.data.slice(1).map((_, i) => this.most(i)));
    return Math.min(this.limit(), Math.max(this.least, most));
  }
}

/** Milliseconds, with as many digits as can be read. */
export const inMs = (value: number) => value.toFixed(value < 1 ? 2 : value < 100 ? 1 : 0);

export function plots(app: App, missed: () => number): HTMLElement {
  let period_ms = Infinity; // from frame to frame: what takes longer comes too late
  const latency = new Plot('Latency', [
    { label: 'longest', color: '--faint' },
    { label: '1 in 100', color: '--plot-blue' },
    { label: 'typical', color: '--accent' },
  ], ([, p99, p50]) => `${inMs(p50!)} / ${inMs(p99!)} ms`, 0.1, (most) => `longest ${inMs(most)} ms`, () => period_ms);
  const rate = new Plot('Frames', [{ label: 'Hz', color: '--good', fill: 'rgba(111,214,168,.08)' }],
    ([hz]) => `${hz!.toFixed(1)} Hz`, 30);
  const drops = new Plot('Lost', [
    { label: 'rig', color: '--plot-red' },
    { label: 'viewer', color: '--plot-violet' },
    { label: 'late', color: '--accent' }, // left later than a period of the rig after they arrived
  ], ([rig, viewer, late]) => `${rig} / ${viewer} / ${late} per s`, 5);
  const all = [latency, rate, drops];
  let shown = '', lost = 0, viewer = 0, late = 0, at = -1, came_ms = -Infinity;
  app.client.on('stats', () => {
    if (shown !== app.selected) {
      shown = app.selected;
      for (const plot of all) plot.clear();
      at = -1;
    }
    const entry = app.entry();
    if (!entry) return;
    const time_s = performance.now() / 1000;
    const live = entry.live;
    if (live && entry.rateHz > 0) period_ms = 1000 / entry.rateHz;
    latency.add(time_s, live ? [entry.latencyMaxUs, entry.latencyP99Us, entry.latencyP50Us].map((us) => us / 1000) : [null, null, null]);
    rate.add(time_s, live ? [entry.rateHz] : [null]);
    const [rigNow, viewerNow, lateNow] = [Number(entry.lost), missed(), Number(entry.overBudget)];
    const more = (now: number, before: number) => at < 0 ? 0 : Math.max(0, now - before);
    drops.add(time_s, [more(rigNow, lost), more(viewerNow, viewer), more(lateNow, late)]);
    [lost, viewer, late, at] = [rigNow, viewerNow, lateNow, time_s];
    came_ms = performance.now();
  });
  const look = () => {
    const { linkState: link, daemonState: daemon } = app.client;
    if (link.kind === 'open' && daemon.up && performance.now() - came_ms < SILENT_MS) return;
    at = -1; // losses during a pause do not belong to one second
    for (const plot of all) plot.grey();
  };
  app.watch(look);
  setInterval(look, 1000);
  // Where the page is narrow they are folded at first.
  const fold = h('button', {
    className: 'quiet fold', 'aria-expanded': 'false', onclick: () => {
      const folded = box.classList.toggle('folded');
      fold.setAttribute('aria-expanded', String(!folded));
    },
  }, 'Plots');
  const box = h('footer', { className: 'plots folded' }, fold, ...all.map(({ element }) => element));
  return box;
}
