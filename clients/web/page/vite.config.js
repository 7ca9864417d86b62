import { defineConfig } from 'vite';

// `npm run dev` serves the page and uses a running gateway.
const gateway = process.env.STYLEWEB ?? 'http://127.0.0.1:7080';

export default defineConfig({
  build: { target: 'es2022', chunkSizeWarningLimit: 2000 },
  server: { proxy: { '/ws': { target: gateway, ws: true } } },
});
