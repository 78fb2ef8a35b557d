/** What the Bode plots are given: the linearised loops, and the points of a sweep. */

import type { LoopResponse, LoopSweep } from '../../app/api/types';
import type { Mark, Series } from '../../plot/types';
import { digits } from '../../ui/units';
import type { LookedAt } from './loop-store.svelte';

export const VIEWS = [
  { view: 'open', name: 'L', title: 'Open loop L = C P' },
  { view: 'closed', name: 'T', title: 'Closed loop T = L/(1 + L)' },
  { view: 'sensitivity', name: 'S', title: 'Sensitivity S = 1/(1 + L)' },
] as const;
export type LoopView = (typeof VIEWS)[number]['view'];

export interface Shown {
  present: LookedAt | null;
  chosen: LookedAt | null;
}

const LOWEST = 1; // Hz
const DEGREES = 180 / Math.PI;

/** Frequencies below the plot are left out, so that its axis fits what is shown. */
function within({ frequency }: LoopResponse, values: readonly number[]): [number[], number[]] {
  const first = Math.max(
    0,
    frequency.findIndex((f) => f >= LOWEST),
  );
  return [frequency.slice(first), values.slice(first)];
}

function lines(shown: Shown, values: (response: LoopResponse) => readonly number[]): Series[] {
  const of = (looked: LookedAt | null, name: string, style: Partial<Series>): Series[] => {
    if (!looked) return [];
    const [x, y] = within(looked.response, values(looked.response));
    return [{ name, x, y, kind: 'line', ...style }];
  };
  return [
    ...of(shown.present, 'present', { ink: 'a' }),
    ...of(shown.chosen, 'chosen', { ink: 'b', dash: 'dash' }),
  ];
}

export function curvesOf(shown: Shown, view: LoopView): Series[] {
  return lines(shown, (response) => response[view].magnitude);
}

export function phasesOf(shown: Shown): Series[] {
  return lines(shown, ({ open }) => open.phase.map((phase) => phase * DEGREES));
}

/** Points of a sweep of the simulation, and the linearised loop at the velocity of its motion. */
export function sweepSeries(
  swept: LoopSweep | null,
  view: LoopView,
  part: 'magnitude' | 'phase',
  of = '',
): Series[] {
  if (!swept) return [];
  const unit = part === 'phase' ? DEGREES : 1;
  const scaled = (loop: LoopResponse) => loop[view][part].map((value) => value * unit);
  const [x, y] = within(swept.linearised, scaled(swept.linearised));
  const speed = `${String(Number(digits(swept.velocity * 1e3)))} mm/s`;
  return [
    { name: `linear, ${speed}`, x, y, kind: 'line', ink: 'muted', dash: 'dot' },
    {
      name: `sweep${of}, ${speed}`,
      x: swept.frequency,
      y: scaled(swept),
      kind: 'points',
      marker: 'cross',
      ink: 'text',
    },
  ];
}

/** Crossover and gain one of L, bandwidth of T, peak of S. */
export function marksOf(looked: LookedAt | null, view: LoopView): Mark[] {
  const figures = looked?.figures;
  if (!figures) return [];
  const found: Mark[] = [];
  if (view === 'open') {
    found.push({ axis: 'y', at: 1, label: '1', ink: 'muted', dash: 'dash' });
    if (figures.crossover !== null) {
      found.push({
        axis: 'x',
        at: figures.crossover,
        label: 'crossover',
        ink: 'muted',
        dash: 'dot',
      });
    }
  } else if (view === 'closed' && figures.bandwidth !== null) {
    found.push({ axis: 'x', at: figures.bandwidth, label: 'bandwidth', ink: 'muted', dash: 'dot' });
  } else if (view === 'sensitivity') {
    found.push({ axis: 'y', at: figures.Ms, label: 'Ms', ink: 'muted', dash: 'dash' });
  }
  return found;
}
