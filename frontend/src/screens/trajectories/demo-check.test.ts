import { describe, expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/demo-checks.json';
// @ts-expect-error: generated JavaScript has no types
import * as generated from '../../../../tests/fixtures/motions.js';
import { readChecked } from './feasibility';
import type { Scenario } from '../../app/api/types';
import { Beyond } from '../../app/whatif/changed-lanes';
import { Refused } from '../../app/whatif/refused-changes';
import type { MotionCode } from '../../app/demo/motion-code';
import { checkPath, packed } from '../../app/demo/path-check';
import { slowDown } from '../../app/demo/slower';

type Trajectory = Scenario['trajectory'];
type Document = (typeof fixture.checks)[0];

const code = generated as unknown as MotionCode;
const plant = fixture.plant as unknown as Scenario['plant'];
const cases = fixture.checks.map((each, i) => [i, each.trajectory.kind, each] as const);
const of = ({ trajectory }: Document) => trajectory as unknown as Trajectory;
const checked = (document: Document) =>
  readChecked(packed(checkPath(code, of(document), plant, fixture.bins)));

/** Compares documents whose numbers two libraries of elementary functions round. */
function same(own: unknown, exact: unknown, place = ''): void {
  if (typeof exact === 'number') {
    const off = Math.abs((own as number) - exact);
    expect(off, `${place}: ${String(own)}, ${exact}`).toBeLessThanOrEqual(
      1e-9 * Math.abs(exact) + 1e-11,
    );
  } else if (typeof exact === 'object' && exact !== null) {
    expect(Object.keys(own as object), place).toEqual(Object.keys(exact));
    for (const [key, each] of Object.entries(exact)) {
      same((own as Record<string, unknown>)[key], each, `${place}.${key}`);
    }
  } else expect(own, place).toBe(exact);
}

describe.each(cases)('the check of path %i, a %s', (_, __, document) => {
  it('finds what the server’s finds', () => {
    const { duration, examined, length, extent, violation_count, time, ...own } = checked(document);
    const numbers = { duration, examined, length, extent, violation_count, step: time.step };
    for (const [name, value] of Object.entries(numbers)) {
      same(value, document[name as keyof Document], name);
    }
    expect(own.feasible).toBe(document.violation_count === 0);
    same(own.violations, document.violations);
    same(own.peaks, document.peaks);
    expect(own.notes.join()).toContain('motionlab serve');
  });

  it('has the server’s columns', () => {
    const { columns } = checked(document);
    expect([...columns.keys()]).toEqual(Object.keys(document.columns));
    for (const [name, [minimum, maximum]] of Object.entries(document.columns)) {
      const largest = Math.max(...[...(minimum ?? []), ...(maximum ?? [])].map(Math.abs));
      const near = (own: ArrayLike<number> | undefined, exact: number[] | undefined) => {
        expect(own).toHaveLength(exact?.length ?? Number.NaN);
        exact?.forEach((value, i) => {
          const off = Math.abs((own?.[i] ?? Number.NaN) - value);
          expect(off, `${name}, bin ${i}`).toBeLessThanOrEqual(1e-6 * largest);
        });
      };
      near(columns.get(name)?.minimum, minimum);
      near(columns.get(name)?.maximum, maximum);
    }
  });

  it('has the server’s curve', () => {
    const { outline } = checked(document);
    expect(outline === null).toBe(document.outline === null);
    document.outline?.places.forEach(([x, y], i) => {
      expect(outline?.x[37 * i]).toBeCloseTo(x as number, 8);
      expect(outline?.y[37 * i]).toBeCloseTo(y as number, 8);
      expect(outline?.edge[37 * i]).toBe(document.outline?.edges[i]);
    });
  });

  it('is slowed down as by the server', () => {
    if (document.stretch === null) {
      expect(() => slowDown(code, of(document), plant)).toThrow(Refused);
    } else if (document.stretch * document.examined > 40) {
      // Each trial samples all of it.
      expect(() => slowDown(code, of(document), plant)).toThrow(Beyond);
    } else {
      const { trajectory, stretch } = slowDown(code, of(document), plant);
      expect(stretch).toBeCloseTo(document.stretch, 9);
      expect(checkPath(code, trajectory, plant, 10).head.feasible).toBe(true);
    }
  });
});

it('a time-optimal path is the server’s to plan, and one that takes too long to check', () => {
  const path = of(cases[0]?.[2] as Document);
  const slow = { ...path, v_max: 1e-5 } as Trajectory;
  for (const each of [{ ...path, law: 'time_optimal' } as Trajectory, slow]) {
    expect(() => checkPath(code, each, plant, 10)).toThrow(Beyond);
  }
});
