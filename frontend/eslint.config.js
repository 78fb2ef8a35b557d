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

/** Imports point one way: screens -> scopes -> app -> plot -> ui; only App.svelte knows the screens. */
const layers = [
  layer('ui', '^\\.\\./', 'ui imports only ui'),
  layer('scopes', '^(\\.\\./)+(screens/|App\\.svelte)', 'scopes imports app, plot and ui'),
  layer('plot', '^\\.\\./(?!ui/)', 'plot imports plot and ui'),
  layer(
    'app',
    '^(\\.\\./)+(screens/|scopes/|plot/(?!source$)|App\\.svelte)',
    'app imports app and ui, and of plot only source, the curves of a what-if',
  ),
  layer(
    'app/spectrum',
    '^(\\.\\./)+(screens/|App\\.svelte)',
    'app/spectrum imports app, plot and ui',
  ),
  layer('app/views', '^(\\.\\./)+(screens/|App\\.svelte)', 'app/views imports app, plot and ui'),
  ...SCREENS.map((screen) => {
    const others = SCREENS.filter((other) => other !== screen).join('|');
    const regex = `^(\\.\\./)+((screens/)?(${others})/|App\\.svelte)`;
    return layer(`screens/${screen}`, regex, 'a screen imports scopes, app, plot, ui and itself');
  }),
];

export default ts.config(
  { ignores: ['dist/', 'src/app/api/schema.d.ts'] },
  js.configs.recommended,
  ...ts.configs.strict,
  ...svelte.configs.recommended,
  {
    languageOptions: { globals: { ...globals.browser } },
    rules: {
      'no-undef': 'off',
      eqeqeq: 'error',
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
