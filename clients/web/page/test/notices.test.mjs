import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test from 'node:test';

import { claim, licenceText, notices, packageOf } from '../notices.js';

const TEXTS = { MIT: 'MIT: permission is granted' };

// A folder of npm packages: { name: [fields of package.json, { file: text }] }.
function installed(t, packages) {
  const root = mkdtempSync(join(tmpdir(), 'styled-notices-'));
  t.after(() => rmSync(root, { recursive: true }));
  for (const [name, [fields, files]] of Object.entries(packages)) {
    const folder = join(root, 'node_modules', name);
    mkdirSync(folder, { recursive: true });
    writeFileSync(join(folder, 'package.json'), JSON.stringify({ name, version: '1.0.0', license: 'MIT', ...fields }));
    for (const [file, text] of Object.entries(files)) writeFileSync(join(folder, file), text);
  }
  return root;
}

function emitted(root, modules) {
  const files = {};
  const chunk = { modules: Object.fromEntries(modules.map((file) => [join(root, file), {}])) };
  notices(TEXTS).generateBundle.call({ emitFile: (file) => { files[file.fileName] = file.source; } }, {}, { 'index.js': chunk });
  return files;
}

test('a module is of the package that is nearest', () => {
  assert.deepEqual(packageOf('/x/node_modules/@a/b/c.js?v=1'), { folder: '/x/node_modules/@a/b', name: '@a/b' });
  assert.equal(packageOf('/x/node_modules/a/node_modules/b/c.js').name, 'b');
  assert.equal(packageOf('/x/src/main.ts'), undefined);
});

test('what is in the page, and what that depends on, has its notice; types and what is not in it have none', (t) => {
  const root = installed(t, {
    used: [{ dependencies: { part: '1', '@types/x': '1' } }, { LICENSE: 'Copyright used', 'a.js': '' }],
    part: [{}, { 'LICENSE.md': 'Copyright part' }],
    unused: [{}, { LICENSE: 'Copyright unused', 'a.js': '' }],
  });
  const files = emitted(root, ['node_modules/used/a.js', 'src/main.ts']);
  assert.match(files['notices.txt'], /\nused 1\.0\.0, MIT\n=+\n\nSource: \n\nCopyright used\n/);
  assert.match(files['notices.txt'], /Copyright part/);
  assert.doesNotMatch(files['notices.txt'], /unused/);
  assert.deepEqual(JSON.parse(files['packages.json']).map((of) => of.name), ['part', 'used']);
});

test('a package without a licence file has the words of its licence, below the copyright that its source claims', (t) => {
  const root = installed(t, { bare: [{}, { 'a.js': '//----\n// Copyright 2009 K\n//----\nlet a;' }], nothing: [{}, { 'a.js': 'let a;' }],
    unknown: [{ license: 'WTFPL' }, { 'a.js': '/* Copyright U */' }] });
  assert.match(emitted(root, ['node_modules/bare/a.js'])['notices.txt'], /Copyright 2009 K\n\nMIT: permission/);
  assert.throws(() => emitted(root, ['node_modules/nothing/a.js']), /nothing: has no licence file, and no source that claims a copyright/);
  assert.throws(() => emitted(root, ['node_modules/unknown/a.js']), /unknown: has no licence file, and no text of WTFPL is known/);
});

test('a second licence that sources carry is told with the first', (t) => {
  const bsd = '// Copyright 2008 G\n// Redistribution and use in source\n';
  const root = installed(t, { two: [{}, {}] });
  const text = licenceText(join(root, 'node_modules/two'), { name: 'two', license: '(MIT AND BSD-3-Clause)' }, [bsd, bsd], TEXTS);
  assert.equal(text, 'Copyright 2008 G\nRedistribution and use in source\n\nMIT: permission is granted');
});

test('a comment that claims nothing is no claim', () => {
  assert.equal(claim('/* eslint */\nlet a; // Copyright'), '');
  assert.equal(claim('/*!\n * Copyright (c) X\n */let a;'), 'Copyright (c) X');
});
