/** Where a run stopped making sense, as the result document has it. */

import { AXES, LANES, rowOf } from './module';
import type { Divergence } from './tasks';

/** Last ticks of a diverged run whose samples the result lists. */
const LAST_STATES = 5;

/**
 * Names the first channel that is not finite at a tick, else the following error.
 *
 * @param samples (ticks, channels, 2)
 * @param tick counted from the first sample
 */
export function divergenceOf(
  samples: Float32Array,
  channels: readonly string[],
  tick: number,
): Omit<Divergence, 'time'> {
  const value = (k: number, channel: number, lane: number) =>
    samples[(k * channels.length + channel) * LANES + lane] as number;
  const names = channels.flatMap((name, channel) =>
    AXES.map((axis, lane) => ({ name: `${axis}.${name}`, channel, lane })),
  );
  const bad = names.find(({ channel, lane }) => !Number.isFinite(value(tick, channel, lane)));
  const error = rowOf(channels, 'following_error');
  const [x, y] = AXES.map((_, lane) => Math.abs(value(tick, error, lane))) as [number, number];
  const channel = bad?.name ?? `${y > x ? 'y' : 'x'}.following_error`;
  const first = Math.max(0, tick + 1 - LAST_STATES);
  const last_states = Array.from({ length: tick + 1 - first }, (_, k) =>
    Object.fromEntries(
      names.map(({ name, channel, lane }) => [name, finite(value(first + k, channel, lane))]),
    ),
  );
  return { channel, last_states };
}

/** A number as it is, or the name of one that is not finite. */
function finite(value: number): number | string {
  if (Number.isNaN(value)) return 'nan';
  return Number.isFinite(value) ? value : value > 0 ? 'inf' : '-inf';
}
