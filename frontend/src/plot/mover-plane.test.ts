import { expect, it, vi } from 'vitest';
import { recorder } from './recorder';
import { StillSource } from './source';
import { magnification, PlaneView } from './mover-plane';

it('magnifies errors to a visible, round size', () => {
  expect(magnification(0.03, 20.5e-6)).toBe(200);
  expect(magnification(0.03, 2.6e-6)).toBe(2000);
  expect(magnification(2.5e-6, 0.5e-6)).toBe(1);
});

it('magnifies nothing when there is no error', () => {
  expect(magnification(0.03, 0)).toBe(1);
  expect(magnification(0, Number.NaN)).toBe(1);
});

it('draws no trace over the axes', () => {
  const { canvas, calls } = recorder();
  vi.stubGlobal('devicePixelRatio', 1);
  const view = new PlaneView(canvas, ['A']);
  const columns = new Map(
    ['x.position_reference', 'y.position_reference', 'A.x.following_error', 'A.y.following_error']
      .map((column) => [column, Float32Array.from({ length: 9 }, (_, i) => Math.sin(i))] as const)
      .map(([column, values]) => [column, { minimum: values, maximum: values }]),
  );
  const source = new StillSource(0, 1, 9, columns);
  view.draw(source, { from: 0, to: 8 }, 8);
  const names = calls.map(([name]) => name);
  const from = names.indexOf('clip');
  expect(calls[from - 1]).toEqual(['rect', 58, 0, 328, 280]);
  // Grid and labels lie outside, traces and places inside.
  expect(names.lastIndexOf('fillText')).toBeLessThan(from);
  expect(names.indexOf('arc')).toBeGreaterThan(from);
  expect(names.filter((name) => name === 'stroke').length).toBeGreaterThan(2);
  expect(names.slice(0, from).filter((name) => name === 'stroke')).toHaveLength(1);
  expect(names.at(-1)).toBe('restore');
  vi.unstubAllGlobals();
});

/** A source of 40 s at 2 kHz: laps of 3 s, and one sample of A that is far off. */
function laps(odd: number): StillSource {
  const count = 80_000;
  const of = (f: (t: number) => number) =>
    Float32Array.from({ length: count }, (_, i) => f(i * 0.0005));
  const error = of(() => 1e-6);
  error[odd] = 9e-6;
  const columns: [string, Float32Array][] = [
    ['x.position_reference', of((t) => 0.015 * Math.cos((2 * Math.PI * t) / 3))],
    ['y.position_reference', of((t) => 0.015 * Math.sin((2 * Math.PI * t) / 3))],
    ['A.x.following_error', error],
    ['A.y.following_error', of(() => 0)],
  ];
  return new StillSource(
    0,
    0.0005,
    count,
    new Map(columns.map(([name, values]) => [name, { minimum: values, maximum: values }])),
  );
}

it('draws the whole of a long stretch, and its largest error even of a single sample', () => {
  const drawn = (odd: number) => {
    const { canvas, calls } = recorder();
    vi.stubGlobal('devicePixelRatio', 1);
    const view = new PlaneView(canvas, ['A']);
    view.draw(laps(odd), { from: 0, to: 40 }, Number.NaN);
    vi.unstubAllGlobals();
    return { view, lines: calls.filter(([name]) => name === 'lineTo') };
  };
  // In the first lap as in the last, at any place within a bin.
  for (const odd of [3, 1017, 40_111, 79_990]) {
    const { view, lines } = drawn(odd);
    // As much as the largest error takes, and not the thousandth of it that a mean would leave.
    expect(view.factor).toBe(magnification(0.03, 9e-6));
    expect(lines.length).toBeGreaterThan(10_000);
  }
});
