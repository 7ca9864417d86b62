// Objects that a rig tracks besides the body, on the stage.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Matrix4, Vector3 } from 'three';

import { Props } from './dist/props.js';
import { turn } from './support.mjs';

// A page's canvas, as far as a label needs it.
globalThis.document = { createElement: () => ({ append() {}, getContext: () => ({ measureText: () => ({ width: 10 }), strokeText() {}, fillText() {} }) }) };

const prop = (name, position, rotation = [0, 0, 0, 1]) => ({ name, position, rotation });
// Centimetres, +Z up: the scene's +Y.
const scene = new Matrix4().makeScale(0.01, 0.01, 0.01).multiply(new Matrix4().set(1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1));

test('a prop stands where the rig has it, in metres, turned as there, whatever the unit', () => {
  const props = new Props();
  props.show({ props: [prop('sword', [100, 20, 150], turn([0, 0, 1], Math.PI / 2))] }, { scene });
  assert.deepEqual(props.place('sword').map((x) => Math.round(1000 * x)), [1000, 1500, -200]);
  const [cross] = props.group.children;
  const tip = new Vector3(0.16, 0, 0).applyMatrix4(cross.matrix); // its x points along the rig's y, the scene's -z
  assert.deepEqual(tip.toArray().map((x) => Math.round(1000 * x)), [1000, 1500, -360]);
});

test('props that a frame has not go, and come again', () => {
  const props = new Props();
  const show = (...names) => props.show({ props: names.map((name) => prop(name, [0, 0, 0])) }, { scene });
  show('sword', 'chair');
  assert.equal(props.group.children.length, 4);
  show('chair');
  assert.equal(props.place('sword'), undefined);
  show();
  assert.equal(props.group.children.length, 0);
  show('sword');
  assert.equal(props.group.children.length, 2);
});
