import { describe, expect, it } from 'vitest';
import { lookup, pixelOf } from './colour-map';
import { cellAt, colourRange, contour, edges, keysOf, moved, paint } from './heat-grid';

describe('cells', () => {
  it('meet half way between their centres, on the scale of the axis', () => {
    expect(edges([0, 1, 3])).toEqual([-0.5, 0.5, 2, 4]);
    const log = edges([1, 100], true);
    [0.1, 10, 1000].forEach((edge, i) => expect(log[i]).toBeCloseTo(edge));
  });

  it('are found by a value, and not beyond the edges', () => {
    const between = [0, 1, 3, 4];
    expect([-0.1, 0, 0.9, 1, 3.5, 4, 4.1].map((at) => cellAt(between, at))).toEqual([
      -1, 0, 0, 1, 2, 2, -1,
    ]);
  });

  it('are reached by keys and not left', () => {
    expect(moved(null, 'ArrowUp', 1, 5, 7)).toEqual({ i: 2, j: 3 });
    expect(moved({ i: 4, j: 6 }, 'ArrowRight', 10, 5, 7)).toEqual({ i: 4, j: 6 });
    expect(moved({ i: 1, j: 1 }, 'ArrowDown', 1, 5, 7)).toEqual({ i: 1, j: 0 });
    expect(moved({ i: 1, j: 1 }, 'x', 1, 5, 7)).toBeNull();
  });
});

describe('colours', () => {
  it('span the values there are', () => {
    expect(
      colourRange({ label: 'f' }, [
        [1, null],
        [Number.NaN, 4],
      ]),
    ).toEqual({ low: 1, high: 4 });
    expect(colourRange({ label: 'f', log: true }, [[0, 10, 100]])).toEqual({ low: 10, high: 100 });
  });

  it('reach as far up as down from a centre', () => {
    expect(colourRange({ label: 'f', centre: 0 }, [[-1, 3]])).toEqual({ low: -3, high: 3 });
  });

  it('are read in both of their lengths', () => {
    expect(pixelOf('#fff')).toBe(0xffffffff);
    expect(pixelOf('#1a2')).toBe(pixelOf('#11aa22'));
  });

  it('get lighter from low to high', () => {
    const light = (pixel: number) =>
      0.2126 * (pixel & 255) + 0.7152 * ((pixel >> 8) & 255) + 0.0722 * ((pixel >> 16) & 255);
    const levels = Array.from(lookup('sequential'), light);
    expect(levels).toHaveLength(256);
    levels.slice(1).forEach((level, i) => expect(level).toBeGreaterThan((levels[i] ?? 0) - 0.8));
    expect(lookup('sequential')[0]).toBe(pixelOf('#440154'));
  });
});

it('a picture shows every cell, and hatches those without a value', () => {
  const image = new Uint32Array(4);
  paint(image, {
    width: 2,
    height: 2,
    columns: Int32Array.from([0, 1]),
    lines: Int32Array.from([1, 0]),
    rows: [
      [0, 1],
      [null, 0.5],
    ],
    colours: Uint32Array.from([10, 11, 12]),
    share: (value) => value ?? Number.NaN,
    ground: 7,
    hatch: 8,
  });
  expect(Array.from(image)).toEqual([8, 11, 10, 12]);
});

it('points that look alike have one entry of the legend', () => {
  const movers = [1, 2].map((k) => ({
    name: `mover ${k.toString()}`,
    family: 'movers',
    x: k,
    y: k,
  }));
  const names = keysOf([...movers, { name: 'best', x: 0, y: 0 }]).map(({ name }) => name);
  expect(names).toEqual(['movers', 'best']);
});

const xs = Array.from({ length: 21 }, (_, i) => 10 ** (i / 10));
const ys = Array.from({ length: 17 }, (_, j) => 10 ** (j / 8));
const over = (f: (x: number, y: number) => number) =>
  ys.map((y) => xs.map((x) => f(Math.log10(x), Math.log10(y))));

it('finds a straight line where it is, in one piece', () => {
  const { x, y } = contour(xs, ys, over((u, v) => u + v), 2.03); // prettier-ignore
  expect(x.filter((at) => at === null)).toHaveLength(1);
  x.forEach((at, k) => {
    if (at !== null) expect(Math.log10(at) + Math.log10(y[k] ?? NaN)).toBeCloseTo(2.03, 9);
  });
});

it('closes a ring, and keeps two of them apart', () => {
  const ring = (u: number, v: number, at: number) => Math.hypot(u - at, v - 1);
  const both = over((u, v) => Math.min(ring(u, v, 0.5), ring(u, v, 1.5)));
  const { x, y } = contour(xs, ys, both, 0.31);
  const gaps = x.flatMap((at, k) => (at === null ? [k] : []));
  expect(gaps).toHaveLength(2);
  expect([x[0], y[0]]).toEqual([x[(gaps[0] ?? 0) - 1], y[(gaps[0] ?? 0) - 1]]);
});

it('goes half way to what is infinite', () => {
  const { x } = contour([1, 100], [1, 100], [[0, Infinity], [0, Infinity]], 1); // prettier-ignore
  expect(x[0]).toBeCloseTo(10);
});
