import { expect, it } from 'vitest';
import page from '../../../../docs/glossary.md?raw';
import { GLOSSARY } from './glossary';
import { partsOf, termIn } from './phrases';

const sources = import.meta.glob<string>('../../**/*.svelte', {
  query: '?raw',
  import: 'default',
  eager: true,
});

it('explains every term that a screen names', () => {
  const used = Object.values(sources).flatMap((source) => [
    ...[...source.matchAll(/<Term\b[^>]*?\bname="([^"]+)"/g)].map(([, name]) => name ?? ''),
    ...[...source.matchAll(/explains\('([^']+)'\)/g)].map(([, name]) => name ?? ''),
  ]);
  expect(used.length).toBeGreaterThan(3);
  expect(used.filter((name) => !(name in GLOSSARY))).toEqual([]);
});

it('finds the longest words, and none within others', () => {
  expect(partsOf('gain margin at 174 mm/s')).toEqual([
    { text: 'gain margin', term: 'GM' },
    { text: ' at 174 mm/s', term: null },
  ]);
  expect(termIn('RMS e_x')).toBe('RMS');
  expect(termIn('max |e_x|')).toBe('following error');
  expect(termIn('B k_p x')).toBe('k_p');
  expect(termIn('costly notches')).toBeNull();
  expect(partsOf('(LuGre observer, K = 0)').map(({ term }) => term)).toEqual([
    null,
    'LuGre',
    null,
    'K = 0',
    null,
  ]);
});

it('leads every phrase to an entry', () => {
  for (const words of ['steady e_y', 'settling y', 'Bandwidth', 'σ_1', 'pole pitches'])
    expect(termIn(words) ?? '').toSatisfy((name: string) => name in GLOSSARY);
});

it('says what the page of the docs says', () => {
  const [, glossary = ''] = page.split('|---|---|\n').slice(-2);
  const rows = Object.values(GLOSSARY).map(({ name, text }) => `| ${name} | ${text} |\n`);
  expect(glossary).toBe(rows.join(''));
});
