/** What is infeasible, in words: what, where, how much, and what helps. */

import { digits, inScale, quantity } from '../../ui/units';
import type { Limited, Violation } from './feasibility';

const NAMES: Record<Limited, string> = {
  position: 'leaves the stroke',
  step: 'jumps',
  velocity: 'too fast',
  acceleration: 'accelerates too hard',
  thrust: 'needs too much thrust',
};

/** Names what is wrong: "x leaves the stroke". */
export function title({ quantity, axis }: Violation): string {
  return `${axis} ${NAMES[quantity]}`;
}

/** Gives the value against what is allowed. */
export function amount({ value, limit, unit }: Violation): string {
  return `${withUnit(value, unit)}, allowed ±${withUnit(limit, unit)}`;
}

export function placeText([x, y]: readonly [number, number]): string {
  return `x ${mm(x)}, y ${mm(y)} mm`;
}

export function timeText({ start, end }: Violation): string {
  const [from, to] = [digits3(start), digits3(end)];
  return from === to ? `at ${from} s` : `${from} to ${to} s`;
}

function mm(value: number): string {
  const text = (value * 1e3).toFixed(2);
  return text === '-0.00' ? '0.00' : text.replace('-', '−');
}

function digits3(seconds: number): string {
  return seconds === 0 ? '0' : digits(seconds, seconds < 10 ? 3 : 4);
}

/** Formats an SI value with its unit as one text; accelerations in m/s², as on the whole screen. */
export function withUnit(value: number | null | undefined, unit: string): string {
  if (unit === 'm/s^2' && typeof value === 'number') {
    return `${inScale(value, { factor: 1, unit: 'm/s²' })} m/s²`;
  }
  const { number, unit: shown } = quantity(value, unit);
  return shown === '' ? number : `${number} ${shown}`;
}
