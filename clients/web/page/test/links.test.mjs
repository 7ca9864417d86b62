// The addresses that the page answers to and links to.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { aloneOf, isOwnMachine, obsLink, pageLink } from './dist/links.js';

const isColor = (text) => /^(transparent|red|#[0-9a-f]{6})$/.test(text);

test('what is not asked for is the whole page', () => {
  for (const search of ['', '?', '?view=', '?view=whole', '?performer=rig.a', '?quality=low']) assert.equal(aloneOf(search, isColor), undefined);
});

test('a colour that is none is transparent; one in hexadecimal needs no #', () => {
  const background = (bg) => aloneOf(`?view=avatar&bg=${bg}`, isColor).background;
  assert.deepEqual(['', 'nonsense', '00ff00', 'red', 'url(//x)'].map(background), ['transparent', 'transparent', '#00ff00', 'red', 'transparent']);
});

test('a link is read as it was written, whatever the names', () => {
  const wish = { performer: 'rig.a', avatar: 'Mia & Söhne #2+.vrm', background: 'transparent' };
  const link = obsLink('http://host:7080/?view=x&q=1#token=old', wish, 'se-cret');
  assert.deepEqual(aloneOf(new URL(link).search, isColor), wish);
  for (const [text, shown] of [['1', true], ['0', undefined], ['', undefined]]) {
    assert.equal(aloneOf(`?view=avatar&props=${text}`, isColor).props, shown);
  }
  assert.deepEqual(aloneOf(new URL(obsLink('http://host/', { ...wish, props: true })).search, isColor), { ...wish, props: true });
  for (const more of [{ framing: 'bust' }, { framing: 'half', mirror: true }]) {
    assert.deepEqual(aloneOf(new URL(obsLink('http://host/', { ...wish, ...more })).search, isColor), { ...wish, ...more });
  }
  assert.equal(aloneOf('?view=avatar&frame=toes', isColor).framing, undefined);
  assert.equal(new URL(link).hash, '#token=se-cret');
  assert.equal(new URL(obsLink('http://host:7080/', wish)).hash, '');
  assert.equal(pageLink('http://host:7080/?view=x', 't'), 'http://host:7080/#token=t');
});

test('addresses that only this machine reaches', () => {
  const own = (host) => isOwnMachine(`http://${host}:7080/`);
  assert.deepEqual(['localhost', '127.0.0.1', '127.1.2.3', '[::1]', 'a.localhost'].map(own), [true, true, true, true, true]);
  assert.deepEqual(['stage.lan', '192.168.1.7', '[fe80::1]', '127.example.org', 'localhost.example.org'].map(own), [false, false, false, false, false]);
});
