/** Peaks of the reference, and what share of the motor's limits they take. */

import { numberAt } from '../../app/api/scenario-paths';
import type { Axis } from '../../app/api/types';
import { extremes, type SampleSource } from '../../plot/source';

export interface Peaks {
  velocity: number;
  acceleration: number;
  /** Largest share of the motor's limits that any of them takes. */
  share: number;
}

/** Returns the reference's peaks over a source, and how much of the motor's limits they are. */
export function peaks(source: SampleSource, plant: object): Peaks | null {
  const largest = (axis: Axis, what: string): number => {
    const whole = { from: source.start, to: source.start + source.last * source.step };
    return Math.max(...extremes(source, `${axis}.${what}_reference`, whole).map(Math.abs));
  };
  const byAxis = (['x', 'y'] as const).map((axis) => {
    const velocity = largest(axis, 'velocity');
    const acceleration = largest(axis, 'acceleration');
    const share = Math.max(
      velocity / numberAt(plant, `${axis}.velocity_max`),
      acceleration / numberAt(plant, `${axis}.acceleration_max`),
    );
    return { velocity, acceleration, share };
  });
  const most = (key: keyof Peaks) => Math.max(...byAxis.map((each) => each[key]));
  const result = {
    velocity: most('velocity'),
    acceleration: most('acceleration'),
    share: most('share'),
  };
  return Number.isFinite(result.share) ? result : null;
}
