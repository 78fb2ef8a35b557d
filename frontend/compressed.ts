import { readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { brotliCompressSync, gzipSync } from 'node:zlib';
import type { Plugin } from 'vite';

const PACKED = /\.(css|html|js|svg|wasm)$/;

/**
 * Put FILE.br and FILE.gz beside each text and module of the built page, and in the place of FILE in assets,
 * which is all but a few kB. The server sends them as they are to clients that accept them.
 */
export function compressed(): Plugin {
  let folder = '';
  return {
    name: 'compressed',
    apply: 'build',
    configResolved(config) {
      folder = join(config.root, config.build.outDir);
    },
    closeBundle() {
      for (const name of readdirSync(folder, { recursive: true, encoding: 'utf8' })) {
        if (!PACKED.test(name)) continue;
        const path = join(folder, name);
        const content = readFileSync(path);
        // Brotli's quality is the highest unless told otherwise.
        writeFileSync(`${path}.br`, brotliCompressSync(content));
        writeFileSync(`${path}.gz`, gzipSync(content, { level: 9 }));
        if (dirname(name) === 'assets') rmSync(path);
      }
    },
  };
}
