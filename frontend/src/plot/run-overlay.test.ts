import { expect, it, vi } from 'vitest';
import { GhostPath } from './ghost-path';
import { GhostCurve } from './run-overlay';
import { PlaneView } from './mover-plane';
import { recorder } from './recorder';
import { ScopeChart } from './scope-chart';
import { StillSource } from './source';

const NAMES = [
  'x.position_reference',
  'y.position_reference',
  'B.x.following_error',
  'B.y.following_error',
];

function source(size: number, start = 0): StillSource {
  const columns = NAMES.map((name, k) => {
    const values = Float32Array.from({ length: 9 }, (_, i) => (k < 2 ? i : size * i) / 8);
    return [name, { minimum: values, maximum: values }] as const;
  });
  return new StillSource(start, 1, 9, new Map(columns));
}

it('the value axis includes a ghost, which is drawn once more when its run has moved', () => {
  const { canvas, calls } = recorder();
  Object.assign(canvas.element, {
    addEventListener: () => undefined,
    removeEventListener: () => undefined,
    style: {},
  });
  vi.stubGlobal('devicePixelRatio', 1);
  const trace = { column: 'B.x.following_error', label: 'B' };
  const scope = { unit: 'm', traces: [trace] };
  const chart = new ScopeChart(canvas, scope, {} as never, { first: true, last: true });
  const state = {
    range: { from: 0, to: 8 },
    follow: true,
    moments: [],
    cursors: [],
    hover: null,
    selection: null,
  };
  const now = source(1);
  chart.draw(now, { ...state, underlays: [] });
  expect(chart.scale.unit).toBe('m');
  const underlays = [new GhostCurve(source(5000), trace, 'long')];
  chart.draw(now, { ...state, underlays });
  expect(chart.scale.unit).toBe('km');
  const drawn = calls.length;
  chart.draw(now, { ...state, underlays });
  expect(calls).toHaveLength(drawn);
  chart.draw(now, { ...state, underlays: [new GhostCurve(source(5000, 2), trace, 'long')] });
  expect(calls.length).toBeGreaterThan(drawn);
  vi.unstubAllGlobals();
});

it('a ghost shares the value axis of its curve, also where that has one of its own', () => {
  const { canvas } = recorder();
  Object.assign(canvas.element, {
    addEventListener: () => undefined,
    removeEventListener: () => undefined,
    style: {},
  });
  vi.stubGlobal('devicePixelRatio', 1);
  const [x, y] = [
    { column: 'B.x.following_error', label: 'x' },
    { column: 'B.y.following_error', label: 'y', own: true },
  ];
  const scope = { unit: 'm', traces: [x, y] };
  const chart = new ScopeChart(canvas, scope, {} as never, { first: true, last: true });
  const ghost = new GhostCurve(source(5000), y, 'long');
  const drawn = vi.spyOn(ghost, 'draw');
  chart.draw(source(1), {
    range: { from: 0, to: 8 },
    follow: true,
    moments: [],
    cursors: [],
    hover: null,
    selection: null,
    underlays: [ghost],
  });
  expect(chart.scales.map(({ unit }) => unit)).toEqual(['m', 'km']);
  expect(drawn.mock.calls[0]?.[2].shown.unit).toBe('km');
  vi.unstubAllGlobals();
});

it('the movers of a ghost share the magnification, which leaves room for both', () => {
  const { canvas, calls } = recorder();
  vi.stubGlobal('devicePixelRatio', 1);
  const range = { from: 0, to: 8 };
  const alone = new PlaneView(canvas, ['B']);
  alone.draw(source(0.001), range, 8);
  const ghost = new GhostPath(source(0.01), 'B', 'long');
  const both = new PlaneView(canvas, ['B']);
  calls.length = 0;
  both.draw(source(0.001), range, 8, [ghost]);
  expect(both.factor).toBeLessThan(alone.factor);
  expect(ghost.read({ from: 0, to: 4 })).toBeCloseTo(0.00625 * Math.SQRT2);
  expect(ghost.read(range)).toBeCloseTo(0.01 * Math.SQRT2);
  expect(calls.filter(([name]) => name === 'stroke').length).toBeGreaterThan(3);
  vi.unstubAllGlobals();
});

it('an offset moves all times of a run', () => {
  const later = source(1).shifted(2.5);
  expect(later.at('B.x.following_error', 10.5)).toBe(1);
  expect(later.at('B.x.following_error', 1)).toBeNaN();
});
