import { expect, it } from 'vitest';
import type { Checked } from './feasibility';
import { costs } from './retiming-cost';

function checked(lap: number, speed: number, jerk: number, share: number): Checked {
  const column = (value: number) => ({
    minimum: new Float32Array([-value, 0]),
    maximum: new Float32Array([0, value / 2]),
  });
  return {
    examined: lap,
    columns: new Map([
      ['speed', { minimum: new Float32Array([0]), maximum: new Float32Array([speed]) }],
      ['y.jerk', column(jerk)],
    ]),
    peaks: [
      { quantity: 'thrust', axis: 'x', value: 1, limit: 10, share: share / 2, unit: 'N' },
      { quantity: 'thrust', axis: 'y', value: 1, limit: 10, share, unit: 'N' },
      { quantity: 'velocity', axis: 'y', value: 1, limit: 1, share: 1, unit: 'm/s' },
    ],
  } as unknown as Checked;
}

it('a retiming is described by its lap, its peaks and its share of the thrust', () => {
  const rows = costs(checked(4, 0.08, 2, 0.22), checked(2, 0.16, 16, 0.44));
  const cells = rows.map(({ name, unit, now, then, change }) => [name, unit, now, then, change]);
  expect(cells).toEqual([
    ['lap time', 's', '4.00', '2.00', -0.5],
    ['speed', 'mm/s', '80.0', '160', expect.closeTo(1, 5)],
    ['peak accel.', 'm/s²', '0', '0', null],
    ['peak jerk', 'm/s³', '2.00', '16.0', 7],
    ['thrust', '%', '22.0', '44.0', 1],
  ]);
});

it('what is not known is a dash', () => {
  expect(costs(checked(4, 1, 1, 0.1), null).map(({ then, change }) => [then, change])).toEqual(
    Array.from({ length: 5 }, () => ['–', null]),
  );
});
