/** An explained peak as text and bars. */

import type { Why } from '../../../app/api/types';
import { inDecibels, inDegrees } from '../../../parts/loop/margins';
import { among, digits, percent, scaleFor, type Scale } from '../../../ui/units';

export interface WhyRow {
  id: string;
  label: string;
  meaning: string;
  /** Error without the cause, in the unit of the peak. */
  error: string;
  /** Of the longest bar, 0 to 1. */
  length: number;
  /** `70.1 %`; where it helps, how much larger the error would be. */
  share: string;
  helps: boolean;
}

/** A bar is at most so many peaks long. */
const LONGEST = 1.5;

export function unitOf({ peak }: Why): Scale {
  return scaleFor(peak, 'm');
}

/** Where on the bars' track the peak as it is lies. */
export const NOW = 1 / LONGEST;

export function whyRows(why: Why): WhyRow[] {
  const unit = unitOf(why);
  return why.causes.map(({ id, label, meaning, error, share }) => ({
    id,
    label,
    meaning,
    error: error === null ? 'diverges' : among(error, unit),
    length: error === null ? 1 : Math.min(1, error / why.peak / LONGEST),
    share: share === null ? '–' : percent(share).replace(/^\+/, ''),
    helps: share !== null && share < 0,
  }));
}

/** The moment of the peak; of a motion that repeats in the lap that is nearest to another moment. */
function timeNear({ time, period }: Why, near: number | null): number {
  if (near === null || !period) return time;
  return time + Math.max(0, Math.round((near - time) / period)) * period;
}

/**
 * What is asked: `Why does B err by 11.6 µm on y at 10.3 s?`
 *
 * @param near - a moment that is looked at, s; null: times count from the start of the run
 */
export function questionText(why: Why, near: number | null = null): string {
  const unit = unitOf(why);
  const time = timeNear(why, near);
  return `Why does ${why.variant} err by ${among(why.peak, unit)} ${unit.unit} on ${why.axis} at ${Number(time.toFixed(3))} s?`;
}

/** What the change that is offered is: it mends the peak, or comes nearest to it. */
export function mendTitle(why: Why): string {
  const { mend, goal } = why;
  if (!mend) return 'No change';
  if (!mend.reaches) {
    const scale = unitOf(why);
    return `Nothing tried reaches ${among(goal, scale)} ${scale.unit}; what comes nearest`;
  }
  return mend.eased
    ? 'The smallest change that makes no margin worse'
    : 'The smallest change within the margins';
}

/** The change that is offered, with what it reaches; why there is none. */
export function mendText(why: Why): { head: string; rest: string } {
  const { mend, goal, why_not, tried } = why;
  if (!mend && tried === 0) return { head: '', rest: why_not };
  const scale = unitOf(why);
  const target = `${among(goal, scale)} ${scale.unit}`;
  if (!mend) return { head: `Nothing found that reaches ${target}.`, rest: why_not };
  const times = mend.factor === null ? '' : ` × ${digits(mend.factor, 3)}`;
  const margins = [
    mend.gain_margin === null ? '' : `GM ${inDecibels(mend.gain_margin)} dB`,
    mend.phase_margin === null ? '' : `PM ${inDegrees(mend.phase_margin)}°`,
  ].filter((text) => text !== '');
  const reached = `${among(mend.window_error, scale)} ${scale.unit} over the window`;
  const eased = mend.eased ? ['beyond a limit, as now'] : [];
  return { head: `${mend.label}${times}`, rest: [reached, ...margins, ...eased].join(', ') };
}
