/** What a person can have a trigger wait for, and with which values. */

import type { Condition } from './detector';

export const KINDS = [
  {
    kind: 'reversal',
    name: 'reversal of',
    title: 'A velocity changes its sign, also after a rest',
  },
  { kind: 'level', name: 'level of', title: 'A curve passes a level' },
  { kind: 'window', name: 'window of', title: 'A curve leaves a band, or enters it' },
  { kind: 'saturation', name: 'saturation', title: 'A force or a current reaches its limit' },
  { kind: 'mark', name: 'any mark', title: 'The schedule, a change of a parameter, a push' },
] as const;

/** Level of a channel that is 0 or 1. */
const HALF = 0.5;
/** A count of the encoder is 50 nm: below it everything chatters. */
const CHATTER = 1e-7;
const MICROMETRE = 1e-6;

/** Returns the name under which a person finds a condition. */
export function kindOf(condition: Condition): string {
  const saturation = condition.kind === 'level' && condition.channel.endsWith('_saturated');
  return saturation ? 'saturation' : condition.kind;
}

/** Returns a condition of a kind with usual values, of a channel where it fits. */
export function conditionOf(kind: string, channel: string): Condition {
  const [, variant = 'A.', axis = 'x.'] = /^([A-Z]\.)?([xy]\.)?/.exec(channel) ?? [];
  const plain = /_(reference|saturated)$/.test(channel)
    ? `${variant}${axis}following_error`
    : channel;
  switch (kind) {
    case 'reversal':
      return { kind, channel: `${axis}velocity_reference`, slope: 'either' };
    case 'mark':
      return { kind };
    case 'window':
      return { kind, channel: plain, way: 'leaves', low: -MICROMETRE, high: MICROMETRE, hysteresis: CHATTER }; // prettier-ignore
    case 'saturation':
      return { kind: 'level', channel: `${variant}${axis}force_saturated`, slope: 'rising', level: HALF, hysteresis: 0 }; // prettier-ignore
    default:
      return { kind: 'level', channel: plain, slope: 'rising', level: MICROMETRE, hysteresis: CHATTER }; // prettier-ignore
  }
}
