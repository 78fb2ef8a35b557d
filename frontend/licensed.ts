import { readdirSync, readFileSync } from 'node:fs';
import type { Plugin } from 'vite';

/** Put the licences of a package, whose code is part of the page, into licenses/PACKAGE. */
export function licensed(name: string): Plugin {
  const folder = new URL(`./node_modules/${name}/`, import.meta.url);
  return {
    name: 'licensed',
    apply: 'build',
    generateBundle() {
      for (const file of readdirSync(folder)) {
        if (!/^(LICENSE|NOTICE)(\.md|\.txt)?$|swagger-ui-bundle\.js\.LICENSE\.txt$/.test(file))
          continue;
        const fileName = `licenses/${name}/${file}`;
        this.emitFile({ type: 'asset', fileName, source: readFileSync(new URL(file, folder)) });
      }
    },
  };
}
