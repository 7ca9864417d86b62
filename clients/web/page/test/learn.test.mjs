import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Course } from './dist/learn.js';

test('three, two, one, the take, the wait, the end', () => {
  const course = new Course(8, false, 1000);
  assert.deepEqual([1000, 1900, 2000, 2001, 3500, 3999].map((ms) => course.at(ms).left), [3, 3, 2, 2, 1, 1]);
  assert.deepEqual([1000, 3999, 4000].map((ms) => course.due(ms)), [false, false, true]);
  assert.equal(course.at(4100).left, 1); // a slow page: never zero
  course.go(4100);
  assert.equal(course.due(9000), false);
  assert.deepEqual(course.at(4100), { kind: 'take', what: 'style', part: 0, left_s: 8 });
  assert.deepEqual(course.at(8100), { kind: 'take', what: 'style', part: 0.5, left_s: 4 });
  assert.deepEqual(course.at(12100), { kind: 'wait', what: 'style' });
  course.done(12300);
  assert.deepEqual(course.at(12300), { kind: 'over' });
  assert.equal(course.due(99000), false);
});

test('a neutral take comes first, each with its countdown', () => {
  const course = new Course(2, true, 0);
  assert.deepEqual(course.at(0), { kind: 'count', what: 'neutral', left: 3 });
  course.go(3000);
  assert.equal(course.at(4000).what, 'neutral');
  course.done(5200);
  assert.deepEqual(course.at(5200), { kind: 'count', what: 'style', left: 3 });
  assert.equal(course.due(8200), true);
  course.go(8200);
  assert.deepEqual(course.at(9200), { kind: 'take', what: 'style', part: 0.5, left_s: 1 });
});

test('it can be stopped at any time', () => {
  for (const when of ['count', 'take', 'wait']) {
    const course = new Course(2, false, 0);
    if (when !== 'count') course.go(3000);
    assert.equal(course.at(when === 'wait' ? 6000 : 3500).kind, when);
    course.stop();
    assert.equal(course.at(6000).kind, 'over');
    assert.equal(course.due(6000), false);
  }
});

test('a clock that goes back does no harm', () => {
  const course = new Course(2, false, 5000);
  assert.equal(course.at(0).left, 3);
  course.go(8000);
  assert.equal(course.at(0).part, 0);
});
