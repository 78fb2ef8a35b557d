/** Progress and request of an experiment, in words. */

import type {
  AxisIdentification,
  IdentificationPartial,
  IdentificationPlan,
} from '../../app/api/types';
import { digits } from '../../ui/units';

type Evidence = NonNullable<AxisIdentification['record']>;

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

const percent = (share: number) => `${digits(100 * share, 2)} %`;

/** What is read of a run: columns, rate, filter. */
export function readOf(plan: IdentificationPlan): string[] {
  return Object.entries(plan.record ?? {}).map(([axis, record]) => {
    const { position, force, rate, bandwidth, duration } = record;
    return (
      `${axis}: ${position} and ${force}, ${digits(duration, 3)} s at ${digits(rate, 4)} Hz, ` +
      `filter at most ${digits(bandwidth, 3)} Hz`
    );
  });
}

/** What a run could tell about an axis. */
export function evidenceOf(record: Evidence): string[] {
  const { shares, slowest, fastest, reversals, lag, lag_half_width: half } = record;
  const unused = Object.entries(shares)
    .filter(([name, share]) => name !== 'used' && share >= 0.0005)
    .map(([name, share]) => `${percent(share)} ${name}`);
  const rest = unused.length > 0 ? `; ${unused.join(', ')}` : '';
  const speeds = `${digits(slowest * 1e3, 2)} to ${digits(fastest * 1e3, 3)} mm/s`;
  const behind =
    half === null
      ? ': not determined'
      : ` by ${digits(lag * 1e6, 3)} ± ${digits(half * 1e6, 2)} µs`;
  return [
    `Slides at ${speeds}, ${reversals} reversals. ${percent(shares.used ?? 0)} of the samples used${rest}.`,
    `Position noise ${digits(record.noise * 1e9, 2)} nm, filter used ${digits(record.bandwidth, 3)} Hz. ` +
      `Motion behind the force${behind}. ` +
      `Condition number ${digits(record.condition, 2)}.`,
  ];
}

/** Summary of a request, for the list of records. */
export function describe(request: Record<string, unknown>): string {
  const axis = request.axis === 'x' || request.axis === 'y' ? request.axis : 'x and y';
  if (typeof request.run === 'string') return `${axis}, ${request.run}`;
  const set = request.set as Record<string, unknown> | undefined;
  const scenario = request.scenario as { plant?: { name?: string } } | string | undefined;
  const own = typeof scenario === 'object' ? scenario.plant?.name : undefined;
  const motor = typeof set?.plant === 'string' ? set.plant : (own ?? '');
  return [axis, motor].filter((word) => word !== '').join(', ');
}
