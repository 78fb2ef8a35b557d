import { describe, expect, it } from 'vitest';
import type { PaperFigure } from '../../app/api/types';
import { drawingOf } from './figure-plot';

const figure: PaperFigure = {
  id: 'fig5-x',
  group: 'fig5',
  title: 'Fig. 5(a)',
  about: '',
  x: { label: 'time', unit: 's', log: false },
  y: { label: 'following error, x', unit: 'm', log: false },
  series: [
    { label: 'off', role: 'A', kind: 'line', x: [0, 90, 180], y: [1e-6, null, 2e-6] },
    { label: 'peak', role: 'printed', kind: 'points', x: [3], y: [4e-6] },
  ],
  bounds: [
    { label: 'printed, on', low: -1e-5, high: 1e-5, start: 90, end: null },
    { label: 'printed', low: -2e-5, high: 2e-5, start: null, end: null },
    { label: 'limit', low: null, high: 10, start: null, end: null },
  ],
};

describe('a figure', () => {
  it('tells its series apart by more than colour', () => {
    const { series } = drawingOf(figure);
    expect(series[0]).toMatchObject({ ink: 'a', dash: 'solid' });
    expect(series[1]).toMatchObject({ kind: 'points', marker: 'diamond' });
  });

  it('tells series of one role apart', () => {
    const one = figure.series[0];
    const { series } = drawingOf({ ...figure, series: one ? [one, one, one] : [] });
    expect(new Set(series.map(({ dash }) => dash)).size).toBe(3);
  });

  it('draws a bound of a part as a band, one of all of it as lines', () => {
    const { bands, marks } = drawingOf(figure);
    expect(bands).toEqual([
      { name: 'printed, on', x: [90, 180], low: [-1e-5, -1e-5], high: [1e-5, 1e-5], ink: 'text' },
    ]);
    expect(marks.map(({ at, label }) => [at, label])).toEqual([
      [-2e-5, 'printed'],
      [2e-5, ''],
      [10, 'limit'],
    ]);
  });

  it('has axes of one scale where both are places', () => {
    expect(drawingOf(figure).equal).toBe(false);
    const plane = { ...figure, x: { ...figure.y, label: 'position, x' } };
    expect(drawingOf(plane).equal).toBe(true);
  });
});
