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
