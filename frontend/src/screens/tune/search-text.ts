/** What things are called on the Tune screen. */

import type { Constraint, Metric } from './search-form';

/** As they are called on the screen; the server and the command line use the keys. */
export const TITLES: Record<Metric, string> = {
  peak: 'peak error',
  rms: 'RMS error',
  itae: 'ITAE',
  settling: 'settling time',
  effort: 'RMS thrust',
};

export const MEANINGS: Record<Metric, string> = {
  peak: 'Largest following error over the window',
  rms: 'Root mean square of the following error',
  itae: 'Integral of time times |e|, from the start of the window',
  settling: 'Longest settling time of a hold; needs a motion that comes to rest',
  effort: 'Root mean square of the thrust',
};

export const LIMITS: Record<Constraint, { name: string; title: string; unit: string }> = {
  gain_margin: {
    name: 'gain margin ≥',
    title:
      'By which the loop’s gain may grow, or fall, to the stability boundary; from 0.5 to 4 Stribeck velocities',
    unit: 'dB',
  },
  phase_margin: {
    name: 'phase margin ≥',
    title:
      'Distance of the open loop from −180° where its gain is one; from 0.5 to 4 Stribeck velocities',
    unit: '°',
  },
  Ms: {
    name: 'M_s ≤',
    title: 'Peak of the sensitivity 1/(1 + L), from 0.5 to 4 Stribeck velocities',
    unit: '',
  },
  saturated: {
    name: 'saturated ≤',
    title: 'Share of ticks with force or current at its limit',
    unit: '%',
  },
  force: { name: 'thrust ≤', title: 'Largest thrust', unit: 'N' },
};

/** A word or two on what a search or a map was asked for. */
export function describe(request: Record<string, unknown>): string {
  const { axis = 'both', objective = { rms: 1 }, scenario = 'circle' } = request;
  const name = typeof scenario === 'string' ? scenario : (scenario as { name: string }).name;
  const axes = axis === 'both' ? 'x, y' : (axis as string);
  return `${name} ${axes}: ${Object.keys(objective as object).join(' + ')}`;
}
