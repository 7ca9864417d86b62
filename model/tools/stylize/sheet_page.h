#pragma once

#include <string_view>

// The page of stylize --sheet, without its data, which replaces kSheetPlace.
namespace styled::stylize {

inline constexpr std::string_view kSheetPlace = "@DATA@";
inline constexpr const char* kSheetPage = R"html(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'">
<title>Styled: clips and styles</title>
<style>
  :root { color-scheme: light dark; }
  body { font: 14px/1.35 system-ui, sans-serif; margin: 1em; }
  header { position: sticky; top: 0; padding: .5em 0; background: Canvas; z-index: 1; }
  header label { margin-right: 1.5em; }
  section { border-top: 1px solid #8886; margin-top: 1em; }
  h2 { font-size: 1em; margin: .6em 0; overflow-wrap: anywhere; }
  h2 small { font-weight: normal; }
  .cells { display: flex; flex-wrap: wrap; gap: 1em; }
  figure { margin: 0; width: 220px; }
  figcaption { font-weight: bold; overflow-wrap: anywhere; }
  canvas { width: 220px; height: 220px; display: block; background: #8881; }
  ul { margin: .3em 0; padding: 0; list-style: none; font-size: .85em; }
  .warning { color: #b45309; } .error { color: #b91c1c; }
  @media (prefers-color-scheme: dark) { .warning { color: #fbbf24; } .error { color: #f87171; } }
</style>
<header>
  <label><input type="checkbox" id="play" checked> moving</label>
  <label>seen from <input type="range" id="turn" min="-180" max="180" value="90"></label>
  <label>moment <input type="range" id="moment" min="0" max="1" step="0.001" value="0"></label>
  Orange: styled. Grey: the input, at the same moment.
</header>
<main></main>
<script type="application/json" id="data">@DATA@</script>
<script>
'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const byId = (id) => document.getElementById(id);
const add = (parent, tag, text, kind) => {
  const element = parent.appendChild(document.createElement(tag));
  if (text !== undefined) element.textContent = text;
  if (kind) element.className = kind;
  return element;
};
// Millimetres in 16 bits, little end first: 3 per joint.
const points = (text) => {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer), width = 3 * data.joints;
  const at = (i) => view.getInt16(2 * i, true) / 1000;
  const frames = bytes.length / 2 / width;
  // The places at a share of the motion, between its frames.
  return { seconds: (frames - 1) / data.rate_hz, at(share) {
    const frame = share * (frames - 1), first = Math.floor(frame);
    const next = Math.min(first + 1, frames - 1), part = frame - first;
    return Array.from({ length: width }, (_, k) =>
      at(first * width + k) * (1 - part) + at(next * width + k) * part);
  } };
};
const cells = [];
const inSight = new Set();
const watch = new IntersectionObserver((changes) => {
  for (const { target, isIntersecting } of changes) {
    isIntersecting ? inSight.add(target) : inSight.delete(target);
  }
});
for (const row of data.rows) {
  const section = add(document.querySelector('main'), 'section');
  const title = add(section, 'h2', row.clip + ' ');
  if (row.seconds !== undefined) {
    const cut = row.seconds > data.shown_s ? `, its first ${data.shown_s} s are shown` : '';
    add(title, 'small', `${row.seconds.toFixed(1)} s${cut}`);
  }
  const list = add(section, 'div', undefined, 'cells');
  const input = row.input && points(row.input);
  for (const { style, figure, numbers, warning, error } of row.cells) {
    const box = add(list, 'figure');
    add(box, 'figcaption', style || 'output');
    if (error) {
      add(box, 'div', error, 'error');
      continue;
    }
    const canvas = add(box, 'canvas');
    canvas.width = canvas.height = 220 * Math.min(2, window.devicePixelRatio || 1);
    const lines = add(box, 'ul');
    for (const line of numbers) add(lines, 'li', line);
    if (warning) add(lines, 'li', warning, 'warning');
    cells.push({ canvas, input, output: points(figure) });
    watch.observe(canvas);
  }
}
const METRES = 2.2, FLOOR = 0.2; // of a canvas' height; below the floor
function draw({ canvas, input, output }, share, turn) {
  const context = canvas.getContext('2d'), size = canvas.width, scale = size / METRES;
  const before = input.at(share), after = output.at(share);
  const [x, , z] = before; // the hips of the input stay in the middle
  const place = (px, py, pz) => [
    size / 2 + scale * ((px - x) * Math.cos(turn) - (pz - z) * Math.sin(turn)),
    size - scale * (py + FLOOR - 0.12 * ((px - x) * Math.sin(turn) + (pz - z) * Math.cos(turn)))];
  context.clearRect(0, 0, size, size);
  context.fillStyle = '#8888';
  for (let i = -4; i <= 4; ++i) { // dots on the floor, half a metre apart
    for (let k = -4; k <= 4; ++k) {
      const [left, top] = place(Math.round(2 * x + i) / 2, 0, Math.round(2 * z + k) / 2);
      context.fillRect(left, top, 2, 2);
    }
  }
  const stroke = (at, colour, width) => {
    context.strokeStyle = context.fillStyle = colour;
    context.lineWidth = width * scale;
    context.lineCap = 'round';
    for (const [from, to] of data.bones) {
      context.beginPath();
      context.moveTo(...place(...at.slice(3 * from, 3 * from + 3)));
      context.lineTo(...place(...at.slice(3 * to, 3 * to + 3)));
      context.stroke();
    }
    context.beginPath();
    const [left, top] = place(at[12], at[13] + 0.1, at[14]); // joint 4 is the head
    context.arc(left, top, 0.1 * scale, 0, 2 * Math.PI);
    context.fill();
  };
  stroke(before, '#888', 0.025);
  stroke(after, '#ea580c', 0.035);
}
let moment_s = 0, last_ms = 0;
if (matchMedia('(prefers-reduced-motion: reduce)').matches) byId('play').checked = false;
function show(now_ms) {
  if (byId('play').checked) moment_s += Math.min(100, now_ms - last_ms) / 1000;
  last_ms = now_ms;
  const turn = byId('turn').value * Math.PI / 180;
  for (const cell of cells) {
    if (!inSight.has(cell.canvas)) continue;
    const seconds = cell.output.seconds || 1;
    const share = byId('play').checked ? (moment_s % seconds) / seconds : Number(byId('moment').value);
    draw(cell, share, turn);
  }
  requestAnimationFrame(show);
}
byId('moment').addEventListener('input', () => { byId('play').checked = false; });
requestAnimationFrame(show);
</script>
</html>
)html";

}  // namespace styled::stylize
