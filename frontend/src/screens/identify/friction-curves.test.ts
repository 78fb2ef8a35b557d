import { describe, expect, it } from 'vitest';
import {
  bandOf,
  fittedCurve,
  modelCurve,
  plannedSeries,
  pointSeries,
  presliding,
  rangeOf,
  stribeck,
  velocityAxis,
} from './friction-curves';

// The paper's x axis.
const X = { F_c: 0.2399, F_s: 3.5908, v_s: 0.0436, sigma_2: 10.3128 };
const point = (velocity: number, force: number) => ({ velocity, force, deviation: 0, pitches: 1 });

describe('the Stribeck curve', () => {
  it('begins at stiction and ends on Coulomb and viscous friction', () => {
    expect(stribeck(X, 1e-9)).toBeCloseTo(3.5908, 6);
    expect(stribeck(X, 0.4)).toBeCloseTo(0.2399 + 10.3128 * 0.4, 6);
    expect(stribeck(X, 0.0436)).toBeCloseTo(0.2399 + 3.3509 / Math.E + 10.3128 * 0.0436, 6);
  });

  it('is odd but for an offset', () => {
    expect(stribeck(X, -0.03)).toBeCloseTo(-stribeck(X, 0.03), 12);
    const pulled = { ...X, f_0: 0.5 };
    expect(stribeck(pulled, 0.03) + stribeck(pulled, -0.03)).toBeCloseTo(1, 12);
  });

  it('is drawn both ways with a gap at zero', () => {
    const { x, y } = modelCurve(X, { slowest: 0.001, fastest: 0.1 }, 'signed');
    expect([x[0], x.at(-1)]).toEqual([expect.closeTo(-0.1, 9), expect.closeTo(0.1, 9)]);
    expect([...x].sort((a, b) => a - b)).toEqual(x);
    expect(y[x.indexOf(0)]).toBeNaN();
    const folded = modelCurve(X, { slowest: 0.001, fastest: 0.1 }, 'folded');
    expect(Math.min(...folded.x)).toBeGreaterThan(0);
  });
});

describe('points', () => {
  const points = [point(0.01, 3), point(-0.01, -3.2), point(0.1, 1.2), point(-0.1, -1.3)];
  const force = points.map((p) => p.force);

  it('stand where they were measured', () => {
    const [all] = pointSeries(points, force, 'measured', 'signed');
    expect(all?.x).toEqual([0.01, -0.01, 0.1, -0.1]);
    expect(all?.y).toEqual(force);
  });

  it('of both directions have markers of their own when folded', () => {
    const [forth, back] = pointSeries(points, force, 'measured', 'folded');
    expect([forth?.x, forth?.y]).toEqual([
      [0.01, 0.1],
      [3, 1.2],
    ]);
    expect([back?.x, back?.y]).toEqual([
      [0.01, 0.1],
      [3.2, 1.3],
    ]);
    expect(forth?.marker).not.toBe(back?.marker);
  });

  it('and planned motions span the range', () => {
    expect(rangeOf(points, [{ speed: 0.2 }])).toEqual({ slowest: 0.01, fastest: 0.2 });
    expect(rangeOf([], [])).toBeNull();
    expect(velocityAxis({ slowest: 0.01, fastest: 0.2 }, 'signed')).toMatchObject({
      from: expect.closeTo(-0.208, 9) as number,
      to: expect.closeTo(0.208, 9) as number,
    });
    expect(velocityAxis(null, 'signed')).not.toHaveProperty('from');
    expect(velocityAxis(null, 'folded')).toMatchObject({ log: true });
  });

  it('that are planned lie on the believed curve', () => {
    const { x, y } = plannedSeries([{ speed: 0.01 }, { speed: 0.02 }], X, 'signed');
    expect(x).toEqual([-0.02, -0.01, 0.01, 0.02]);
    expect(y).toEqual(Array.from(x, (v) => stribeck(X, v as number)));
  });
});

describe('the fit', () => {
  const curve = {
    velocity: [-0.1, -0.01, 0.01, 0.1],
    force: [-1, -3, 3.4, 1.4],
    low: [-1.1, -3.1, 3.3, 1.3],
    high: [-0.9, -2.9, 3.5, 1.5],
  };

  it('has a gap at zero, and folded loses its offset', () => {
    expect(fittedCurve(curve, 'signed')).toEqual({
      x: [-0.1, -0.01, 0, 0.01, 0.1],
      y: [-1, -3, Number.NaN, 3.4, 1.4],
    });
    const folded = fittedCurve(curve, 'folded');
    expect(folded.x).toEqual([0.01, 0.1]);
    expect(folded.y).toEqual([expect.closeTo(3.2, 9), expect.closeTo(1.2, 9)]);
  });

  it('has its band around it, or around zero for what is left over', () => {
    const [band] = bandOf(curve, 'signed', 'curve');
    expect(band?.low).toEqual([-1.1, -3.1, Number.NaN, 3.3, 1.3]);
    const [left] = bandOf(curve, 'folded', 'zero');
    expect(left?.high).toEqual([expect.closeTo(0.1, 9), expect.closeTo(0.1, 9)]);
    expect(left?.low).toEqual([expect.closeTo(-0.1, 9), expect.closeTo(-0.1, 9)]);
  });

  it('has its band around the folded curve, which is without the offset', () => {
    const { x, y } = fittedCurve(curve, 'folded');
    const [band] = bandOf(curve, 'folded', 'curve');
    expect(band?.x).toEqual(x);
    expect(band?.high).toEqual(y.map((value) => expect.closeTo(value + 0.1, 9) as number));
    expect(band?.low).toEqual(y.map((value) => expect.closeTo(value - 0.1, 9) as number));
  });

  it('without a band has none', () => {
    expect(bandOf({ ...curve, low: null, high: null }, 'signed', 'curve')).toEqual([]);
  });
});

describe('presliding', () => {
  const ramp = {
    rate: 50,
    force_max: 1.8,
    time: [0, 1],
    force: [0, 1.8],
    displacement: [0, 15e-6],
    fitted: [0, 15.1e-6],
  };

  it('is force over displacement, with the line of sigma_0', () => {
    const [measured, fitted, line] = presliding(ramp, 1.2e5);
    expect(measured).toMatchObject({ x: [0, 15e-6], y: [0, 1.8], kind: 'points' });
    expect(fitted).toMatchObject({ x: [0, 15.1e-6], y: [0, 1.8] });
    expect(line?.x).toEqual([0, expect.closeTo(15e-6, 12)]);
  });

  it('draws no more points than the eye tells apart', () => {
    const long = Array.from({ length: 240 }, (_, i) => i);
    const [measured] = presliding({ ...ramp, force: long, displacement: long }, undefined);
    expect(measured?.x).toHaveLength(60);
    expect(measured?.y).toHaveLength(60);
  });
});
