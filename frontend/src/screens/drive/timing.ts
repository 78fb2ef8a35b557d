/** How the loop keeps its time: a histogram, its figures, and what the machine granted. */

import type { DriveStatus } from '../../app/api/types';
import type { Band, Mark, PlotAxis, Series } from '../../plot/types';
import { digits } from '../../ui/units';
import type { FigureRow } from './drive-rows';

type Loop = DriveStatus['loop'];

const MICRO = { factor: 1e6, unit: 'µs' };
/** The foot of the logarithmic axis, so that a single cycle is seen. */
const FOOT = 0.7;

export function histogram({ recent, period }: Loop): {
  x: PlotAxis;
  y: PlotAxis;
  series: Series[];
  bands: Band[];
  marks: Mark[];
} {
  const { bin_width, round_trips, p50, p99, p999 } = recent;
  const most = Math.max(10, ...round_trips);
  const end = bin_width * round_trips.length;
  const counted = round_trips.some((count) => count > 0);
  const percentiles = [
    { at: p50, label: 'p50' },
    { at: p99, label: 'p99' },
    { at: p999, label: 'p99.9' },
  ];
  return {
    x: { label: 'round trip', unit: 's', scale: MICRO, from: 0, to: end },
    y: { label: 'cycles', log: true, from: FOOT, to: 3 * most },
    series: [
      {
        name: 'cycles',
        kind: 'bars',
        ink: 'baseline',
        x: round_trips.map((_, i) => (i + 0.5) * bin_width),
        y: round_trips.map((count) => (counted && count > 0 ? count : null)),
      },
    ],
    bands: counted
      ? [
          {
            name: 'beyond a period',
            x: [period, end],
            low: [FOOT, FOOT],
            high: [3 * most, 3 * most],
            ink: 'bad',
            hatched: true,
          },
        ]
      : [],
    marks: percentiles.flatMap(({ at, label }) =>
      at === null
        ? []
        : [{ axis: 'x' as const, at, label, ink: 'text' as const, dash: 'solid' as const }],
    ),
  };
}

export function timingRows({ recent, late_run, control_time, wake_late }: Loop): FigureRow[] {
  const share = recent.cycles > 0 ? (100 * recent.late) / recent.cycles : Number.NaN;
  const micro = (seconds: number | null) => (seconds === null ? '–' : digits(1e6 * seconds));
  return [
    { name: 'cycles late', value: String(recent.late), unit: '' },
    { name: 'share of all', value: digits(share, 2), unit: '%' },
    { name: 'longest run', value: String(late_run), unit: 'cycles' },
    { name: 'round trip p50', value: micro(recent.p50), unit: 'µs' },
    { name: 'p99', value: micro(recent.p99), unit: 'µs' },
    { name: 'p99.9', value: micro(recent.p999), unit: 'µs' },
    { name: 'control half, most', value: micro(control_time), unit: 'µs' },
    { name: 'woke late, most', value: micro(wake_late), unit: 'µs' },
  ];
}

/** Whether the machine gave the loop what it asked for, and what to do where it did not. */
export function realTime({ priority, priority_wanted, memory_locked, age }: Loop): {
  good: boolean;
  text: string;
  remedy: string;
} {
  // The loop asks once it is compiled.
  if (age === null) return { good: false, text: 'real time not asked for yet', remedy: '' };
  const memory = memory_locked ? 'memory locked' : 'memory not locked';
  if (priority > 0 && memory_locked) {
    return { good: true, text: `SCHED_FIFO ${priority}, memory locked`, remedy: '' };
  }
  if (priority_wanted === 0) {
    return { good: false, text: `without SCHED_FIFO, as configured, ${memory}`, remedy: '' };
  }
  const rights = [
    ...(priority > 0 ? [] : [`LimitRTPRIO=${priority_wanted}`]),
    ...(memory_locked ? [] : ['LimitMEMLOCK=infinity']),
  ];
  return {
    good: false,
    text: priority > 0 ? `SCHED_FIFO ${priority}, ${memory}` : `no SCHED_FIFO, ${memory}`,
    remedy:
      `The loop was refused real time: expect late cycles. Give the server ${rights.join(' and ')}` +
      ' (systemd), the same with ulimit -r and -l, or CAP_SYS_NICE and CAP_IPC_LOCK.',
  };
}

const HELD = 1000; // ms

/** Lets the exchange count as in phase once it has been so in every answer of the last second. */
export class SteadyPhase {
  private since = -Infinity;

  /** Returns a status that came at a time, ms, with the phase as it counts. */
  of(status: DriveStatus, at: number): DriveStatus {
    if (!status.loop.phase_locked) this.since = Infinity;
    else if (this.since > at) this.since = at;
    const steady = at - this.since >= HELD;
    if (steady === status.loop.phase_locked) return status;
    return { ...status, loop: { ...status.loop, phase_locked: steady } };
  }
}
