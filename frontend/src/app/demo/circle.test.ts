import { expect, it } from 'vitest';
import { exampleLanes } from '../../kernel/example-lanes';
import { Beyond } from '../whatif/changed-lanes';
import { type Circle, withCircle } from './circle';

const circle: Circle = {
  kind: 'circle',
  center: { x: 0, y: 0 },
  radius: 0.015,
  frequency: 0.1,
  direction: 'ccw',
  start_angle: 0,
  laps: 2,
  for_ever: true,
  lead_in: null,
};

it('takes a motion of up to a minute, and none beyond it', () => {
  // Two variants, 10 s a lap, 5 s of lead-in.
  expect(withCircle(exampleLanes(), circle, 0).ticks * 0.5).toBe(25);
  for (const longer of [{ laps: 3 }, { laps: 100_000 }, { frequency: 1e-9 }, { lead_in: 1e9 }]) {
    expect(() => withCircle(exampleLanes(), { ...circle, ...longer }, 0)).toThrow(Beyond);
  }
});
