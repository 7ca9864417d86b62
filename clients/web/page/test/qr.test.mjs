// A reader that is not ours reads the codes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import jsqr from 'jsqr';

import { qrOf } from './dist/qr.js';

// The path's modules as an image of 3 pixels a module.
function drawn({ side, path }) {
  const wide = 3 * side;
  const data = new Uint8ClampedArray(4 * wide * wide).fill(255);
  for (const [, x, y] of path.matchAll(/M(\d+) (\d+)h1v1h-1z/g)) {
    for (let i = 0; i < 9; ++i) {
      const at = 4 * ((3 * Number(y) + Math.floor(i / 3)) * wide + 3 * Number(x) + (i % 3));
      data.fill(0, at, at + 3);
    }
  }
  return jsqr(data, wide, wide)?.data;
}

for (const link of ['http://a/', 'http://stage.lan:7080/#token=0123456789abcdef', `http://192.168.100.200:7080/#token=${'x'.repeat(256)}`]) {
  test(`a link of ${link.length} letters`, () => assert.equal(drawn(qrOf(link)), link));
}

test('the reader would notice a code that is another', () => assert.notEqual(drawn(qrOf('http://b/')), 'http://a/'));
