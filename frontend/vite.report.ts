import { defineConfig } from 'vite';

/** The script of reports, which stands in each of them: one file beside the page. */
export default defineConfig({
  publicDir: false,
  build: {
    target: 'es2022',
    emptyOutDir: false,
    lib: {
      entry: 'src/report/main.ts',
      formats: ['iife'],
      name: 'report',
      fileName: () => 'report.js',
    },
  },
});
