import { readFileSync } from 'node:fs';
import { defineConfig } from 'vite';

import { notices } from './notices.js';

// `npm run dev` serves the page and uses a running gateway.
const gateway = process.env.STYLEWEB ?? 'http://127.0.0.1:7080';
// Of licences that a package of the page names without having their text. STYLED_PROTO: the tree's root.
const texts = {
  MIT: readFileSync(new URL('licences/MIT.txt', import.meta.url), 'utf8').trim(),
  get 'Apache-2.0'() {
    return readFileSync(`${process.env.STYLED_PROTO ?? '../../..'}/LICENSE`, 'utf8').trim();
  },
};

export default defineConfig({
  plugins: [notices(texts)],
  build: { target: 'es2022', chunkSizeWarningLimit: 2000 },
  server: { proxy: { '/ws': { target: gateway, ws: true } } },
});
