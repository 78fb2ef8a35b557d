import { describe, expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/demo-motions.json';
// @ts-expect-error: generated JavaScript has no types
import * as generated from '../../../../tests/fixtures/motions.js';
import { exampleLanes } from '../../kernel/example-lanes';
import type { Scenario } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import type { MotionCode } from './motion-code';
import { infeasible } from './motion-limits';
import { withMotion } from './moved-lanes';
import { sampled } from './reference';

const code = generated as unknown as MotionCode;
type Trajectory = Scenario['trajectory'];
const all = fixture as unknown as {
  trajectory: Trajectory;
  reference: (typeof fixture)[0]['reference'];
}[];
const MOST = 1e6;
const limits = { stroke: 0.1, velocity_max: 1, acceleration_max: 20 };
const plant = { x: limits, y: limits } as unknown as Scenario['plant'];
const path = all.find(({ trajectory }) => trajectory.kind === 'path')?.trajectory as object;

describe('a motion in the page', () => {
  it.each(all.map((each) => [each.trajectory.kind, each] as const))(
    'is the server’s: %s',
    (_, { trajectory, reference }) => {
      const own = sampled(code, trajectory, MOST);
      expect(own.ticks).toBe(reference.ticks);
      expect(own.window).toEqual(reference.window);
      expect(own.moving).toEqual(reference.moving);
      const holds = (each: typeof own.holds) =>
        Object.values(each).map((rows) =>
          rows.map((row) => row.map((value) => Number(value.toFixed(11)))),
        );
      expect(holds(own.holds)).toEqual(holds(reference.holds as unknown as typeof own.holds));
      own.end.forEach((each, i) => expect(each).toBeCloseTo(reference.end[i] as number, 13));
      reference.samples.forEach((values, column) => {
        const largest =
          own.columns[column]?.reduce((most, value) => Math.max(most, Math.abs(value)), 0) ?? 0;
        values.forEach((value, i) => {
          const off = Math.abs(
            (own.columns[column]?.[reference.at[i] as number] ?? Number.NaN) - value,
          );
          expect(off, `column ${column}, ${i}`).toBeLessThanOrEqual(1e-10 * largest + 1e-15);
        });
        const size = own.columns[column]?.reduce((sum, value) => sum + Math.abs(value), 0) ?? 0;
        expect(Math.abs(size - (reference.size[column] as number))).toBeLessThanOrEqual(
          1e-9 * size + 1e-12,
        );
      });
    },
  );

  it('is planned by a server where it is time-optimal, samples, or too long', () => {
    for (const trajectory of [
      { ...path, law: 'time_optimal' },
      { kind: 'samples', time: [0, 1], x: [0, 1], y: [0, 0] },
      { kind: 'point', position: { x: 0, y: 0 }, duration: 3000 },
    ]) {
      expect(() => sampled(code, trajectory as unknown as Trajectory, MOST)).toThrow(Beyond);
    }
  });

  it('is refused where the motor cannot follow it', () => {
    const problems = (trajectory: object) =>
      infeasible(code, sampled(code, trajectory as Trajectory, MOST), plant).map(
        ({ message }) => message,
      );
    const line = {
      kind: 'line',
      start: { x: 0, y: 0 },
      end: { x: 0.09, y: 0 },
      edge_time: 0.5,
      dwell: 0,
    };
    expect(problems(line)).toEqual([]);
    expect(problems({ ...line, end: { x: 0.11, y: 0 } })).toEqual([
      "position of x exceeds the motor's",
    ]);
    expect(problems({ ...line, edge_time: 0.05 }).join()).toMatch(
      /velocity of x.*acceleration of x/,
    );
    const step = {
      kind: 'step',
      start: { x: 0, y: 0 },
      height: { x: 0, y: 2e-5 },
      delay: 0.1,
      dwell: 0.1,
    };
    expect(problems(step)).toEqual(["a step of y exceeds the motor's"]);
    expect(problems({ ...path, geometry: 'polyline', law: 'constant_speed' }).join()).toContain(
      'acceleration',
    );
  });

  it('gives lanes their inputs, and where each variant starts', () => {
    const lanes = { ...exampleLanes(), period: 5e-4 };
    const trajectory = {
      kind: 'point',
      position: { x: 0.01, y: -0.02 },
      duration: 0.1,
    } as Trajectory;
    const { lanes: moved } = withMotion(code, lanes, trajectory, 0);
    expect([moved.ticks, moved.stop, moved.inputs?.length]).toEqual([200, 200, 1200]);
    expect(moved.inputs?.[0]).toBe(0.01);
    expect(moved.inputs?.[600]).toBe(-0.02);
    expect([...moved.state.subarray(0, 2)]).toEqual([0.01, -0.02]);
    expect(moved.keys.inputs).not.toBe(lanes.keys.inputs);
  });
});
