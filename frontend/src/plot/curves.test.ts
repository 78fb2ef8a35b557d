import { describe, expect, it } from 'vitest';
import { AxisScale } from './axis-scale';
import { errorEnds, extentOf, nearest, stepped } from './curves';
import { columnsOf } from './table-columns';
import type { Series } from './types';

const x = new AxisScale({ label: 'x', unit: 'm' }, 0, 10, [0, 100]);
const y = new AxisScale({ label: 'y', unit: 'N' }, 0, 10, [100, 0]);

describe('a curve', () => {
  it('has room for its error bars', () => {
    const one: Series = { name: 'a', x: [1, 2], y: [5, 6], error: [1, null] };
    expect(errorEnds(one, 0)).toEqual([4, 6]);
    expect(errorEnds(one, 1)).toBeNull();
    expect(extentOf('y', { label: 'y' }, [one], [])).toEqual({ low: 4, high: 6 });
  });
});

describe('the cursor', () => {
  const line: Series = { name: 'a', x: [0, 1, 2, 3], y: [5, null, 7, 8] };

  it('finds the nearest point along x, but no gap', () => {
    expect(nearest(line, { x: 2.2, y: 0 }, x, y)).toBe(2);
    expect(nearest(line, { x: 1.1, y: 0 }, x, y)).toBe(2);
  });

  it('finds the nearest point in the picture on a loop', () => {
    const loop = { x: [0, 5, 10, 5], y: [5, 10, 5, 0] };
    expect(nearest(loop, { x: 5, y: 1 }, x, y)).toBe(3);
  });

  it('goes to either end at once', () => {
    expect(stepped(line, null, -1e9, x, y)).toEqual({ x: 0, y: 5 });
    expect(stepped(line, null, 1e9, x, y)).toEqual({ x: 3, y: 8 });
  });

  it('steps over gaps and stays at the ends', () => {
    expect(stepped(line, null, 1, x, y)).toEqual({ x: 0, y: 5 });
    expect(stepped(line, { x: 0, y: 5 }, 1, x, y)).toEqual({ x: 2, y: 7 });
    expect(stepped(line, { x: 3, y: 8 }, 1, x, y)).toEqual({ x: 3, y: 8 });
  });
});

describe('the table', () => {
  it('joins curves over x, with empty cells where one has no point', () => {
    const { columns } = columnsOf(
      [
        { name: 'a', x: [0, 1, 2], y: [1, null, 3] },
        { name: 'b', x: [1], y: [9], error: [0.5], kind: 'points' },
      ],
      [],
      x,
      y,
    );
    expect(columns.map(({ name }) => name)).toEqual(['x', 'a', 'b', 'b, from', 'b, to']);
    expect(columns[1]?.cells).toEqual(['1', '–', '3']);
    expect(columns[2]?.cells).toEqual(['', '9', '']);
    expect(columns[4]?.cells[1]).toBe('9.5');
  });

  it('gives a loop an x of its own', () => {
    const { columns } = columnsOf([{ name: 'a', x: [0, 2, 1], y: [1, 2, 3] }], [], x, y);
    expect(columns.map(({ cells }) => cells)).toEqual([
      ['0', '2', '1'],
      ['1', '2', '3'],
    ]);
  });

  it('thins what is too long, ends included', () => {
    const long = Array.from({ length: 1001 }, (_, i) => i / 100);
    const { columns, thinned } = columnsOf([{ name: 'a', x: long, y: long }], [], x, y);
    expect(thinned).toBe(true);
    expect(columns[0]?.cells.length).toBeLessThan(203);
    expect(columns[0]?.cells.at(-1)).toBe('10');
  });
});
