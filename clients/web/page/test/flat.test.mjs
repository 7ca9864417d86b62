// The stage's picture without WebGL.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Matrix4, PerspectiveCamera } from 'three';

import { strokesOf } from './dist/flat.js';

// Four metres away, looking at the origin; a metre there is 100 pixels of 400.
function cameraAt() {
  const camera = new PerspectiveCamera(2 * Math.atan(0.5) * 180 / Math.PI, 2, 0.1, 60);
  camera.position.set(0, 0, 4);
  camera.updateMatrixWorld();
  return camera;
}
const line = (from, to, more = {}) => ({ from, to, width_m: 0.1, shade: 1, ...more });
const outline = (points, lines, at = new Matrix4()) => ({ points: points.flat(), at, lines, color: 0xff0000 });
const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-9, `${a} is not ${b}`);

test('a line is where the camera sees it, as wide as it is there', () => {
  const [stroke] = strokesOf([outline([[1, 0, 0], [1, 1, 0]], [line(0, 1)])], cameraAt(), 800, 400);
  [[stroke.from.x, 500], [stroke.from.y, 200], [stroke.to.x, 500], [stroke.to.y, 100], [stroke.width, 10]].forEach((pair) => near(...pair));
  assert.equal(stroke.style, '#ff0000');
});

test('twice as far it is half as wide, and drawn first', () => {
  const points = [[0, 0, 0], [0, 1, 0], [0, 0, -4], [0, 1, -4]];
  const [far, close] = strokesOf([outline(points, [line(0, 1), line(2, 3)])], cameraAt(), 800, 400);
  near(far.width, 5);
  near(close.width, 10);
});

test('the place of the thing and a lift count', () => {
  const [stroke] = strokesOf([outline([[0, 0, 0]], [line(0, 0, { lift_m: 0.5 })], new Matrix4().makeTranslation(-1, 0, 0))], cameraAt(), 800, 400);
  near(stroke.from.x, 300);
  near(stroke.from.y, 150);
});

test('no line is drawn to a point behind the camera', () => {
  assert.deepEqual(strokesOf([outline([[0, 0, 0], [0, 0, 5]], [line(0, 1)])], cameraAt(), 800, 400), []);
});
