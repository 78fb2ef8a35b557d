import { svelte } from '@sveltejs/vite-plugin-svelte';
import { defineConfig } from 'vitest/config';
import { compressed } from './compressed.ts';
import { licensed } from './licensed.ts';

/** What the first page needs is one file: many small ones are a fifth larger as they are sent. */
const FIRST = /\/src\/main\.ts$/;

interface Graph {
  getModuleInfo(id: string): { importers: readonly string[] } | null;
}

/** Whether modules are loaded with the first page; those that are imported later are not. */
function firstPage(): (id: string, graph: Graph) => boolean {
  const known = new Map<string, boolean>();
  return function first(id, graph) {
    const before = known.get(id);
    if (before !== undefined) return before;
    known.set(id, false); // of a circle
    const importers = graph.getModuleInfo(id)?.importers ?? [];
    const is = FIRST.test(id) || importers.some((importer) => first(importer, graph));
    known.set(id, is);
    return is;
  };
}

const first = firstPage();

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
    rolldownOptions: {
      input: ['index.html', 'docs.html'],
      // svelte defines an element of its own there, which the page has no use for.
      treeshake: { moduleSideEffects: [{ test: /custom-element\.js$/, sideEffects: false }] },
      output: {
        codeSplitting: {
          groups: [{ debugName: 'lab', name: (id, graph) => (first(id, graph) ? 'lab' : null) }],
        },
      },
    },
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
