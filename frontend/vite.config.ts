import { svelte } from '@sveltejs/vite-plugin-svelte';
import { defineConfig } from 'vitest/config';
import { compressed } from './compressed.ts';
import { licensed } from './licensed.ts';

const server = process.env.MOTIONLAB_SERVER ?? 'http://127.0.0.1:8000';

export default defineConfig({
  // Relative: the page is also served from other paths than the root, without a server of its own.
  base: './',
  plugins: [svelte(), licensed('svelte'), licensed('swagger-ui-dist'), compressed()],
  // Tests import the binary fixtures that the Python tests read too.
  assetsInclude: ['**/*.bin'],
  build: {
    target: 'es2022',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rolldownOptions: { input: ['index.html', 'docs.html'] },
  },
  server: {
    // The server refuses foreign origins, so the proxy speaks in the server's own name.
    proxy: {
      '/api': {
        target: server,
        changeOrigin: true,
        ws: true,
        headers: { origin: server },
      },
      '/scene': { target: server, changeOrigin: true, ws: true, headers: { origin: server } },
    },
  },
  test: {
    include: ['src/**/*.test.ts'],
    environment: 'node',
    setupFiles: ['src/app/fields/example-fields.ts'],
  },
});
