import { expect, test } from 'vitest';
import {
  facts,
  namesOf,
  peakMarks,
  peakRows,
  plotsOf,
  spectrumSeries,
  valueAxis,
  zoomed,
  type ColumnSpectrum,
} from './spectrum-view';

const LINE = { frequency: 50, kind: 'line', amplitude: 2e-8, rms: 1.4e-8, density: 1e-16 } as const;
const BROAD = { frequency: 180, kind: 'loop', amplitude: null, rms: 5e-9, density: 1e-17 } as const;

const COLUMN: ColumnSpectrum = {
  name: 'B.x.following_error',
  unit: 'm',
  start: 2000,
  stop: 6000,
  missing: 3,
  resolution: 0.5,
  noise_bandwidth: 0.75,
  bins: 3,
  rms: 2e-8,
  frequency: [1, 50, 1000],
  density: [1e-18, 1e-16, 1e-20],
  amplitude: [1.2e-9, 1.2e-8, 1.2e-10],
  cumulative: [1e-9, 2e-8, 2e-8],
  peaks: [
    { ...LINE, above_loop: 14.26 },
    { ...BROAD, above_loop: 1.2 },
  ],
  loop: {
    variant: 'B',
    axis: 'x',
    velocity: 0.022,
    force: 0.0026,
    count: 4e-10,
    frequency: [1, 1000],
    density: [4e-18, 1e-20],
    gain: [1e-6, 1e-9],
  },
  note: '',
};
const NAMES = namesOf([{ name: COLUMN.name, unit: 'm' }]);
const SHARED = { ...COLUMN, name: 'temperature', loop: null, peaks: [] };

test('a density is drawn as its root, and the loop beside it in the same measure', () => {
  const [curve, loop] = spectrumSeries('density', [COLUMN], NAMES);
  expect(curve?.name).toBe('B');
  expect(Array.from(curve?.y ?? [])[0]).toBeCloseTo(1e-9, 15);
  expect(loop).toMatchObject({ name: 'loop of B', dash: 'dash' });
  expect(Array.from(loop?.y ?? [])[0]).toBeCloseTo(2e-9, 15);
  const [, asAmplitude] = spectrumSeries('amplitude', [COLUMN], NAMES);
  expect(Array.from(asAmplitude?.y ?? [])[0]).toBeCloseTo(Math.sqrt(2 * 4e-18 * 0.75), 15);
  expect(spectrumSeries('cumulative', [COLUMN], NAMES)).toHaveLength(1);
  expect(spectrumSeries('density', [SHARED], NAMES)).toHaveLength(1);
});

test('the axis has one prefix, of a density by the root of frequency', () => {
  expect(valueAxis('density', [COLUMN]).scale?.unit).toBe('nm/√Hz');
  expect(valueAxis('amplitude', [COLUMN]).scale?.unit).toBe('nm');
  expect(valueAxis('amplitude', []).scale?.unit).toBe('');
});

test('peaks are named by frequency, and told in a table', () => {
  expect(peakMarks([COLUMN], NAMES).map(({ label }) => label)).toEqual([
    'B 50.00 Hz',
    'B 180.0 Hz',
  ]);
  expect(peakRows([COLUMN, SHARED], NAMES).map(({ kind, cells }) => [kind, ...cells])).toEqual([
    ['line', '20.0 nm', '14.0 nm', '14.3'],
    ['loop’s own', '–', '5.00 nm', '1.2'],
  ]);
});

test('what it is of and how it was taken stands below it', () => {
  const text = facts(COLUMN, 0.0005, NAMES);
  for (const part of [
    '1.000 to 3.000 s',
    'resolution 0.500 Hz',
    'bandwidth 0.750 Hz',
    '3 left out',
  ]) {
    expect(text).toContain(part);
  }
  expect(text).toContain('about 22.0 mm/s');
  expect(facts(SHARED, 0.0005, NAMES)).not.toContain('loop');
});

test('frequencies are zoomed about one, within what there is', () => {
  const all = { low: 1, high: 1000 };
  expect(zoomed(all, 0.5, 100, all)).toEqual({ low: 10, high: expect.closeTo(316.2, 1) });
  expect(zoomed({ low: 10, high: 300 }, 10, 50, all)).toBeNull();
  const narrow = { low: 99.9, high: 100.1 };
  expect(zoomed(narrow, 0.5, 100, all)).toEqual(narrow);
});

test('columns of one unit share a plot, and each has a name and a look of its own', () => {
  const thrust = { ...SHARED, name: 'B.x.thrust', unit: 'N' };
  const other = { ...COLUMN, name: 'A.x.following_error' };
  expect(
    plotsOf([COLUMN, thrust, other]).map(({ title, columns }) => [title, columns.length]),
  ).toEqual([
    ['Spectrum of following error x', 2],
    ['Spectrum of thrust x', 1],
  ]);
  const channels = ['A.x.following_error', 'B.x.following_error', 'B.y.following_error'];
  const names = namesOf(channels.map((name) => ({ name, unit: 'm' })));
  expect([...names.values()].map(({ label }) => label)).toEqual(['A x', 'B x', 'B y']);
  const looks = [...names.values()].map(({ ink, dash = 'solid' }) => `${ink} ${dash}`);
  expect(new Set(looks).size).toBe(3);
  expect(looks[0]).toBe('a solid');
});
