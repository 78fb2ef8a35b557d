import { expect, it, vi } from 'vitest';

vi.stubGlobal('location', { href: 'http://lab.test/', search: '' });
const { SCREENS } = await import('../../app/screen.svelte');
const { CONTENTS, destinations } = await import('./destinations');
const { matching } = await import('./commands');

const all = destinations(SCREENS.map(({ screen }) => screen));
const first = (words: string) => matching(all, words)[0];

it.each([
  ['fft', 'Spectrum'],
  ['psd', 'Spectrum'],
  ['spectrum', 'Spectrum'],
  ['lissajous', 'XY'],
  ['xy', 'XY'],
  ['ballbar', 'Ballbar'],
  ['circularity', 'Ballbar'],
  ['stribeck', 'Stribeck curve'],
  ['accuracy', 'Positioning'],
  ['energy', 'Cost'],
  ['bode', 'Bode plot'],
  ['phase margin', 'Phase margin, gain margin, M_s'],
  ['export', 'Export of a run'],
])('%s finds %s first', (words, name) => {
  expect(first(words)?.name.split(':')[0]).toBe(name);
});

it('finds the friction view by Stribeck, too', () => {
  expect(matching(all, 'stribeck').map(({ place }) => place)).toContain('view');
});

it('leads to parts that are on their screens', () => {
  const sources = import.meta.glob<string>('../../screens/**/*.svelte', {
    query: '?raw',
    import: 'default',
    eager: true,
  });
  for (const { screen, part } of CONTENTS) {
    const text = Object.entries(sources)
      .filter(([path]) => path.includes(`/screens/${screen}/`))
      .map(([, source]) => source)
      .join('');
    expect(/label="([^"{]+)"/.test(text)).toBe(true);
    expect(text.includes(`label="${part}"`), `${part} on ${screen}`).toBe(true);
  }
});

it('leads nowhere that a demo does not have', () => {
  const demo = destinations(['lab']);
  expect(new Set(demo.map(({ place }) => place))).toEqual(new Set(['Lab']));
});
