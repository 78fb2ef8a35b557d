/** Writing an expression: the word at the caret, and what may complete it. */

import { channelName } from '../plot/scope-catalog';
import type { Channel } from '../plot/source';

/** Functions by name, as they are called; docs/expressions.md. */
export const FUNCTIONS: Readonly<Record<string, string>> = {
  abs: 'abs(u), the size',
  sqrt: 'sqrt(u), the square root',
  sign: 'sign(u), -1, 0 or 1',
  sin: 'sin(u), of radians',
  cos: 'cos(u), of radians',
  min: 'min(u, v), the lesser',
  max: 'max(u, v), the larger',
  hypot: 'hypot(u, v), root of the sum of squares',
  derivative: 'derivative(u), by time',
  integral: 'integral(u), over time',
  lowpass: 'lowpass(u, Hz), first order',
  highpass: 'highpass(u, Hz), first order',
  bandpass: 'bandpass(u, Hz, Hz), first order each',
  mean: 'mean(u, s), of the last seconds',
  delay: 'delay(u, s), as it was',
};

export interface Completion {
  /** What is written. */
  text: string;
  name: string;
  detail: string;
}

/** The letters, digits and dots before the caret: where they begin, and what they are. */
export function wordAt(text: string, caret: number): { start: number; word: string } {
  const [word = ''] = /[A-Za-z_][\w.]*$/.exec(text.slice(0, caret)) ?? [];
  return { start: caret - word.length, word };
}

/** A channel as it is written in an expression: in quotes where it is no plain name. */
function written(name: string): string {
  return /^[A-Za-z_]\w*(\.[A-Za-z_]\w*)*$/.test(name) ? name : `"${name}"`;
}

/** Functions that begin with a word, then channels that have it. */
export function completions(word: string, channels: readonly Channel[]): Completion[] {
  const sought = word.toLowerCase();
  const functions = Object.entries(FUNCTIONS)
    .filter(([name]) => name.startsWith(sought))
    .map(([name, detail]) => ({ text: `${name}(`, name, detail }));
  const matches = channels
    .filter(({ name }) => `${name} ${channelName(name)}`.toLowerCase().includes(sought))
    .map(({ name, unit }) => ({
      text: written(name),
      name,
      detail: `${channelName(name)}${unit === '1' ? '' : `, ${unit}`}`,
    }));
  const whole = matches.length === 1 && matches[0]?.text === word;
  return whole ? [] : [...functions, ...matches];
}

/** The text with its word at the caret replaced, and where the caret is then. */
export function completed(
  text: string,
  caret: number,
  by: string,
): { text: string; caret: number } {
  const { start } = wordAt(text, caret);
  return { text: `${text.slice(0, start)}${by}${text.slice(caret)}`, caret: start + by.length };
}
