import { expect, it } from 'vitest';
import { LoopsInPage } from './loops';
import { Memory } from './memory';
import { type About, type Exports, LANES } from './module';

const ROWS = [
  'controller.k_p',
  'controller.k_d',
  'mass',
  'compensation.law',
  'compensation.enabled',
];
const about = {
  parameters: [...ROWS, 'law.p_3'],
  exports: { linearise: ['parameters', 'axis', 'speeds', 'velocity'], margins: ['axis', 'radii'] },
  loops: {
    speeds: [0, 1, 4],
    blocks: { speeds: 24, velocity: 24, radii: 24, limits: 32, worst: 48 },
  },
  quotients: { laws: [[], ['law.p_3']], message: 'no linear loop' },
} as unknown as About;

/** Loops whose module writes some moduli of poles, and velocities twice the speeds. */
function loopsOf(radii: number[]) {
  const calls: string[] = [];
  const memory = new Memory(1e6);
  const kernel = {
    linearise(_: number, axis: number, speeds: number, velocity: number) {
      calls.push(`linearise ${axis}`);
      const from = memory.float64(speeds, 3).map((speed) => 2 * speed);
      memory.float64(velocity, 3).set(from);
    },
    margins(axis: number, at: number) {
      calls.push(`margins ${axis}`);
      // limits and margins lie after the moduli, which end on a multiple of 16 bytes
      memory.float64(at, 3).set(radii);
      memory.float64(at + 32, 4).set([10, Number.NaN, 30, 40]);
      memory.float64(at + 64, 6).set([3, 2, 1, 8, Number.POSITIVE_INFINITY, 0]);
    },
  } as unknown as Exports;
  const loops = new LoopsInPage(about, kernel, memory);
  const of = (...values: number[]) =>
    loops.of('A', Float64Array.from(values.flatMap((value) => [value, value])), {
      parameters: memory.place(8 * LANES * values.length),
      tables: 0,
    });
  return { of, calls };
}

it('linearises anew for everything but gains', () => {
  const { of, calls } = loopsOf([0.5, 0.6, 0.7]);
  const both = ['linearise 0', 'margins 0', 'linearise 1', 'margins 1'];
  of(1, 2, 3, 0, 1, 0);
  expect(calls.splice(0)).toEqual(both);
  of(4, 5, 3, 0, 1, 0);
  expect(calls.splice(0)).toEqual(['margins 0', 'margins 1']);
  of(4, 5, 6, 0, 1, 0);
  expect(calls).toEqual(both);
});

it('reads stability, limits and margins, infinite ones as none', () => {
  expect(loopsOf([0.5, 0.9, 0.7]).of(1, 2, 3, 0, 1, 0).axes.x).toEqual({
    stable: true,
    k_p_limit: 30,
    k_d_limit: 40,
    standstill: { stable: true, k_p_limit: 10, k_d_limit: null },
    worst: {
      stable: true,
      velocity: 2,
      gain_margin: { value: 3, velocity: 2 },
      phase_margin: { value: 1, velocity: 8 },
      Ms: null,
    },
  });
});

it('has no margins of a loop that is unstable somewhere', () => {
  const loop = loopsOf([0.5, 1.1, 0.7]).of(1, 2, 3, 0, 1, 0).axes.x;
  const { worst } = loop ?? {};
  expect([loop?.stable, worst?.stable, worst?.gain_margin]).toEqual([true, false, null]);
});

it('refuses a law that is a quotient while it acts', () => {
  const { of, calls } = loopsOf([0.5, 0.6, 0.7]);
  expect(of(1, 2, 3, 1, 1, 0.5)).toEqual({ axes: {}, note: 'no linear loop' });
  expect(calls).toEqual([]);
  expect(of(1, 2, 3, 1, 0, 0.5).note).toBeNull();
  expect(of(1, 2, 3, 1, 1, 0).note).toBeNull();
});
