/** Progress and request of an experiment, in words. */

import type { IdentificationPartial, IdentificationPlan } from '../../app/api/types';

/** "1 to 20 whole pole pitches" of the motions that are planned. */
export function pitchesOf(plan: IdentificationPlan): string {
  const all = Object.values(plan.axes).flatMap((motions) => motions.map(({ pitches }) => pitches));
  const [least, most] = [Math.min(...all), Math.max(...all)];
  if (all.length === 0) return 'no pole pitch';
  if (most === 1) return 'one whole pole pitch';
  return least === most ? `${most} whole pole pitches` : `${least} to ${most} whole pole pitches`;
}

/** Progress: "x: uniform motion 12 of 32". */
export function doing({ axis, step, done, count }: IdentificationPartial['standing']): string {
  switch (step) {
    case 'sliding':
      return `${axis ?? ''}: uniform motion ${done + 1} of ${count}, there and back`;
    case 'presliding':
      return `${axis ?? ''}: force ramp ${done + 1} of ${count}`;
    case 'record':
      return `${axis ?? ''}: regression over the record`;
    case 'comparison':
      return 'The circle with the old model and the new one';
    default:
      return step satisfies never;
  }
}

/** Summary of a request, for the list of records. */
export function describe(request: Record<string, unknown>): string {
  const axis = request.axis === 'x' || request.axis === 'y' ? request.axis : 'x and y';
  const set = request.set as Record<string, unknown> | undefined;
  const scenario = request.scenario as { plant?: { name?: string } } | string | undefined;
  const own = typeof scenario === 'object' ? scenario.plant?.name : undefined;
  const motor = typeof set?.plant === 'string' ? set.plant : (own ?? '');
  return [axis, motor].filter((word) => word !== '').join(', ');
}
