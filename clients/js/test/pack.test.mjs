// The tarball of npm pack, installed in a folder that knows nothing of the tree, without the network.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, symlinkSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const library = path.join(here, '..');
const modules = path.dirname(path.dirname(createRequire(import.meta.url).resolve('ws/package.json')));
const npm = (folder, ...args) =>
  execFileSync('npm', [...args, '--offline', '--no-audit', '--no-fund', '--loglevel=error', `--cache=${folder}/.cache`],
    { cwd: folder, encoding: 'utf8', stdio: 'pipe' });
const node = (folder, ...args) =>
  execFileSync(process.execPath, args, { cwd: folder, encoding: 'utf8', stdio: 'pipe' });

let folder;
before(() => {
  folder = mkdtempSync(path.join(tmpdir(), 'styled-pack-'));
  writeFileSync(path.join(folder, 'package.json'), '{"private": true, "type": "module"}');
  const [{ filename }] = JSON.parse(npm(folder, 'pack', library, '--json'));
  // Its dependencies come from here, since a test downloads nothing.
  npm(folder, 'install', '--install-links', filename, path.join(modules, 'ws'), path.join(modules, '@bufbuild/protobuf'));
});
after(() => folder && rmSync(folder, { recursive: true, force: true }));

test('has what it needs to run, its types, and no tests', () => {
  const installed = path.join(folder, 'node_modules/styled-client');
  const { exports, dependencies } = JSON.parse(readFileSync(path.join(installed, 'package.json'), 'utf8'));
  for (const files of Object.values(exports)) {
    for (const file of Object.values(files)) assert.ok(existsSync(path.join(installed, file)), file);
  }
  assert.deepEqual(Object.keys(dependencies), ['@bufbuild/protobuf', 'ws']);
  assert.ok(!existsSync(path.join(installed, 'test')));
});

test('runs in Node, without three', () => {
  writeFileSync(path.join(folder, 'use.mjs'), `
    import { StyledClient, frameTopic } from 'styled-client';
    const client = new StyledClient({ url: 'http://127.0.0.1:1' });
    console.log(frameTopic('rig.anna', 'canonical'), typeof client.latest);
    client.close();
  `);
  assert.match(node(folder, 'use.mjs'), /^styled\/rig\.anna\/canonical\/ function/);
  assert.throws(() => node(folder, '--input-type=module', '-e', "import 'styled-client/three-vrm'"), /Cannot find package/);
});

test('has a three-vrm helper, and types for both', () => {
  for (const name of ['three', '@pixiv', '@types']) {
    symlinkSync(path.join(modules, name), path.join(folder, 'node_modules', name));
  }
  assert.equal(node(folder, '--input-type=module', '-e',
    "import { VrmPoser } from 'styled-client/three-vrm'; console.log(VrmPoser.name)"), 'VrmPoser\n');
  const program = `
    import type { VRM } from '@pixiv/three-vrm';
    import { StyledClient, type Update } from 'styled-client';
    import { VrmPoser } from 'styled-client/three-vrm';
    export function wear(vrm: VRM, client: StyledClient): void {
      const poser = new VrmPoser(vrm);
      client.on('frame', ({ body, frame }: Update) => body && poser.pose(body, frame));
    }`;
  const check = (text) => {
    writeFileSync(path.join(folder, 'use.ts'), text);
    return node(folder, path.join(modules, 'typescript/bin/tsc'), '-p', '.');
  };
  // As a bundler finds modules, and as Node does.
  for (const [module, moduleResolution] of [['ES2022', 'Bundler'], ['NodeNext', 'NodeNext']]) {
    const config = { compilerOptions: { target: 'ES2022', module, moduleResolution, strict: true, noEmit: true, skipLibCheck: true,
      lib: ['ES2022', 'DOM'], types: [] }, files: ['use.ts'] };
    writeFileSync(path.join(folder, 'tsconfig.json'), JSON.stringify(config));
    assert.equal(check(program), '', module);
    assert.throws(() => check(program.replace('pose(body, frame)', 'pose(frame, body)')), (error) => /TS2345/.test(error.stdout), module);
  }
});
