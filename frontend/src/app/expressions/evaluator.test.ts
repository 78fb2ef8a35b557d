import { describe, expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/expressions.json';
import { Ring } from '../stream/ring';
import { Evaluator } from './evaluator';

const samples: Record<string, readonly (number | null)[]> = fixture.samples;
const typed = (name: string) =>
  Float32Array.from(samples[name] ?? [], (each) => each ?? Number.NaN);

function close(values: ArrayLike<number>, expected: readonly (number | null)[]): void {
  expect(values.length).toBe(expected.length);
  expected.forEach((value, i) => {
    const each = values[i] as number;
    if (value === null) expect(each, `sample ${i}`).toBeNaN();
    else expect(Math.abs(each - value), `sample ${i}`).toBeLessThan(1e-6 * Math.abs(value) + 1e-9);
  });
}

describe('Evaluator', () => {
  it.each(fixture.cases)('computes $formula as the server does', ({ channels, steps, values }) => {
    const sources = channels.map(typed);
    const evaluator = new Evaluator(steps);
    for (let turn = 0; turn < 2; turn++) {
      const results = values.map((_, i) =>
        evaluator.next((place) => sources[place]?.[i] as number),
      );
      close(results, values);
      evaluator.reset();
    }
  });
});

describe('Ring', () => {
  const [u, v] = [typed('u'), typed('v')];
  const cases = fixture.cases.map(({ formula, ...rest }) => ({ column: `=${formula}`, ...rest }));

  function held(ring: Ring, column: string): number[] {
    return Array.from({ length: ring.end - ring.start }, (_, i) => ring.at(column, ring.start + i));
  }

  it('computes columns as frames come, from what is there, and anew after a late frame', () => {
    const ring = new Ring(96, ['u', 'v']);
    ring.compute(cases.slice(0, 5));
    const part = (from: number, to: number) => [u.subarray(from, to), v.subarray(from, to)];
    ring.write(0, part(0, 30));
    ring.write(50, part(50, 96));
    ring.compute(cases);
    ring.patch(30, part(30, 50));
    for (const { column, values } of cases) close(held(ring, column), values);
    const low = new Float32Array(6);
    const high = new Float32Array(6);
    const { column, values } = cases[0] as (typeof cases)[number];
    ring.reduce(column, 0, 16, 6, low, high);
    const first = values.slice(0, 16) as number[];
    expect(low[0]).toBeCloseTo(Math.min(...first), 5);
    expect(high[0]).toBeCloseTo(Math.max(...first), 5);
    ring.compute([]);
    expect(ring.has(column)).toBe(false);
  });

  it('carries what an operation remembers beyond the oldest sample', () => {
    const ring = new Ring(48, ['u', 'v']);
    ring.compute(cases);
    for (let tick = 0; tick < 96; tick += 8) {
      ring.write(tick, [u.slice(tick, tick + 8), v.slice(tick, tick + 8)]);
      ring.at('u', tick);
    }
    for (const { column, values } of cases) close(held(ring, column), values.slice(48));
  });
});
