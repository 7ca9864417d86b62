// The page's answer to what a company may use.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { create } from '@bufbuild/protobuf';
import { CommercialUse, ListReplySchema, StyleInfoSchema } from 'styled-client';

import { licenceParts, licenceText } from './dist/licences.js';

const YES = CommercialUse.YES, NO = CommercialUse.NO;
const list = create(ListReplySchema, {
  styles: [
    { name: 'normal', neutral: true, licence: 'CC-BY-NC-4.0', commercialUse: NO },
    { name: 'giant', licence: 'CC-BY-NC-4.0', credit: 'A', commercialUse: NO },
    { name: 'zombie', licence: 'free', credit: 'B', commercialUse: YES },
    { name: 'mummy', licence: 'free', credit: 'B', commercialUse: YES },
    { name: 'mine', made: true },
  ],
  terms: [{ file: 'v2.safetensors', licence: 'CC-BY-NC-4.0', credit: 'A', commercialUse: NO }, { file: 'own.safetensors' }],
});

test('styles by permission, files, and the credits of styles that differ from their file', () => {
  assert.deepEqual(licenceParts(list), [
    ['For commercial use, with the credits below', 'zombie, mummy'],
    ['Not for commercial use', 'giant'],
    ['Not known: read the licence, or that of the example', 'mine'],
    ['v2.safetensors: CC-BY-NC-4.0', 'A'],
    ['own.safetensors: no licence is given', ''],
    ['zombie, mummy', 'free; B'],
  ]);
});

test('a permission that no style has is left out', () => {
  const titles = licenceParts(create(ListReplySchema, { styles: [{ name: 'a', licence: 'x', commercialUse: YES }] })).map(([title]) => title);
  assert.deepEqual(titles, ['For commercial use, with the credits below', 'a']);
});

test('a card says that its style is not for commercial use', () => {
  assert.equal(licenceText(create(StyleInfoSchema, { licence: 'L', commercialUse: NO })), 'licence L, not for commercial use');
  assert.equal(licenceText(create(StyleInfoSchema, { licence: 'L', commercialUse: YES })), 'licence L');
  assert.equal(licenceText(create(StyleInfoSchema, {})), '');
});
