// Makes src/gen from proto/styled/v1 with protoc (Debian: protobuf-compiler) and protoc-gen-es.
// STYLED_PROTO: the folder that contains proto/; default: the top of the checkout.
import { execFileSync } from 'node:child_process';
import { mkdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = process.env.STYLED_PROTO ?? path.resolve(here, '../..');
const out = path.join(here, 'src/gen');
const plugin = createRequire(import.meta.url).resolve('@bufbuild/protoc-gen-es/bin/protoc-gen-es');
rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
execFileSync(
  process.env.PROTOC ?? 'protoc',
  [
    `--proto_path=${root}`,
    `--plugin=protoc-gen-es=${plugin}`,
    `--es_out=${out}`,
    '--es_opt=target=ts,import_extension=js',
    ...['body', 'checkpoint', 'fate', 'frame', 'look', 'stats', 'control'].map((name) => `proto/styled/v1/${name}.proto`),
  ],
  { stdio: 'inherit', cwd: root },
);
