import { readdirSync } from 'node:fs';
import js from '@eslint/js';
import svelte from 'eslint-plugin-svelte';
import globals from 'globals';
import ts from 'typescript-eslint';

const SCREENS = readdirSync(new URL('src/screens', import.meta.url));

/** Forbids files of a folder to import, at once or lazily, what `regex` finds in the relative path. */
function layer(folder, regex, message) {
  const selector = `ImportExpression[source.value=/${regex.replaceAll('/', '\\u002F')}/]`;
  return {
    files: [`src/${folder}/**`],
    rules: {
      'no-restricted-imports': ['error', { patterns: [{ regex, message }] }],
      'no-restricted-syntax': ['error', { selector, message }],
    },
  };
}

/** Imports point one way: screens -> scopes -> study -> parts -> app -> kernel, plot -> ui; only App.svelte knows the screens. */
const ROOMS = ['ui', 'plot', 'kernel', 'app', 'parts', 'study', 'scopes', 'report'];
const layers = [
  ...ROOMS.map((room, height) => {
    const above = ROOMS.slice(height + 1).map((name) => `${name}/`);
    // Of plot, app takes the curves of a what-if alone.
    if (room === 'app') above.push('plot/(?!source$)');
    const regex = `^(\\.\\./)+(${[...above, 'screens/', 'App\\.svelte'].join('|')})`;
    return layer(room, regex, `${room} imports no room above it`);
  }),
  ...SCREENS.map((screen) => {
    const others = SCREENS.filter((other) => other !== screen).join('|');
    const regex = `^(\\.\\./)+((screens/)?(${others})/|App\\.svelte)`;
    return layer(`screens/${screen}`, regex, 'a screen imports every room but another screen');
  }),
];

export default ts.config(
  { ignores: ['dist/', 'lanes.js', 'src/app/api/schema.d.ts'] },
  js.configs.recommended,
  ...ts.configs.strict,
  ...svelte.configs.recommended,
  {
    languageOptions: { globals: { ...globals.browser } },
    rules: {
      // TypeScript checks both.
      'no-undef': 'off',
      'no-import-assign': 'off',
      eqeqeq: 'error',
      // A name is the thing that it holds; tests/project/test_names.py says so of files.
      'id-denylist': ['error', 'found', 'told', 'asked', 'said', 'wanted', 'given'],
      '@typescript-eslint/consistent-type-imports': 'error',
      '@typescript-eslint/switch-exhaustiveness-check': 'off',
    },
  },
  {
    files: ['**/*.svelte', '**/*.svelte.ts'],
    languageOptions: { parserOptions: { parser: ts.parser } },
  },
  ...layers,
);
