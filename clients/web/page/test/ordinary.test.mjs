// Styles of examples that turn out to be ordinary motion.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Ordinary } from './dist/ordinary.js';

const entry = (more = {}, style = 'mine') => [{ performer: 'rig.b', hardlyStyled: true, live: true, look: { mix: [] } },
  { performer: 'rig.a', live: true, hardlyStyled: true, look: { mix: [{ style, weight: 1 }, { style: 'old', weight: 0 }] }, ...more }];

test('a style is ordinary once two statistics in a row call its wearer hardly styled', () => {
  const ordinary = new Ordinary('rig.a', 'mine');
  assert.deepEqual([entry(), entry(), entry()].map((now) => ordinary.heard(now)), [false, true, true]);
  assert.equal(ordinary.heard(entry({ hardlyStyled: false })), false, 'it is visible after all');
  assert.equal(ordinary.heard(entry()), false, 'counted anew');
});

test('another style, a mix, a silent performer and an absent one tell nothing', () => {
  const ordinary = new Ordinary('rig.a', 'mine');
  ordinary.heard(entry());
  const mix = [{ style: 'mine', weight: 0.5 }, { style: 'old', weight: 0.5 }];
  for (const now of [entry({}, 'old'), entry({ look: { mix } }), entry({ live: false }), entry({ look: undefined }), []]) {
    assert.equal(ordinary.heard(now), undefined);
  }
  assert.equal(ordinary.heard(entry()), false, 'counted anew');
});
