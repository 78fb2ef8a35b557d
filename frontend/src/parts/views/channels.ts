/** Which channels suggest themselves, and how a pair is that of another variant. */

import { channelName } from '../../plot/scope-catalog';
import { type Channel, isMath } from '../../plot/source';
import { looksOf } from '../../plot/palette';
import type { Look, Series } from '../../plot/types';
import type { Sampled } from './views-api';

/** Channels over each other: x, then y. */
export type Pair = readonly [x: string, y: string];

/** Pairs that are worth a look, `*` for the variant. */
export const PAIRS: readonly { name: string; pair: Pair }[] = [
  { name: 'Friction over velocity, x', pair: ['*.x.velocity', '*.x.friction'] },
  { name: 'Friction over velocity, y', pair: ['*.y.velocity', '*.y.friction'] },
  { name: 'Error over position, x', pair: ['x.position_reference', '*.x.following_error'] },
  { name: 'Error over position, y', pair: ['y.position_reference', '*.y.following_error'] },
  { name: 'Error y over error x', pair: ['*.x.following_error', '*.y.following_error'] },
  { name: 'Position y over x', pair: ['*.x.position', '*.y.position'] },
  { name: 'Reference y over x', pair: ['x.position_reference', 'y.position_reference'] },
  { name: 'Thrust over position, x', pair: ['*.x.position', '*.x.thrust'] },
  { name: 'Current b over a, x', pair: ['*.x.current_a', '*.x.current_b'] },
];

const has = (channels: readonly Channel[], column: string) =>
  channels.some(({ name }) => name === column);

/** Following errors of x, else those of y, else the first channel. */
export function errorChannels(channels: readonly Channel[], variants: readonly string[]): string[] {
  for (const axis of ['x', 'y']) {
    const errors = variants
      .map((variant) => `${variant}.${axis}.following_error`)
      .filter((column) => has(channels, column));
    if (errors.length > 0) return errors;
  }
  return channels.slice(0, 1).map(({ name }) => name);
}

/** Of the chosen channels those that the source has, and expressions. */
export function present(channels: readonly string[], known: readonly Channel[]): string[] {
  return channels.filter((column) => isMath(column) || has(known, column));
}

/** Pairs of channels from a list of them, one after the other. */
export function pairsOf(channels: readonly string[]): Pair[] {
  return Array.from({ length: channels.length >> 1 }, (_, i) => {
    return [channels[2 * i] ?? '', channels[2 * i + 1] ?? ''] as const;
  });
}

/** The known pairs that a source has, each of every variant. */
export function knownPairs(channels: readonly Channel[], variants: readonly string[]) {
  return PAIRS.flatMap(({ name, pair }) => {
    const owners = pair.some((column) => column.startsWith('*')) ? variants : [''];
    const pairs = owners
      .map((variant) => pair.map((column) => column.replace('*', variant)) as [string, string])
      .filter((columns) => columns.every((column) => has(channels, column)));
    return pairs.length > 0 ? [{ name, pairs }] : [];
  });
}

/** The pair that suggests itself: the first that there is, else the first two channels. */
export function firstPairs(channels: readonly Channel[], variants: readonly string[]): Pair[] {
  const [known] = knownPairs(channels, variants);
  if (known) return known.pairs;
  const [x, y] = channels;
  return x && y ? [[x.name, y.name]] : [];
}

/** The variant that a pair is of; empty where it is of none, or of two. */
export function variantOf([x, y]: Pair): string {
  const letters = [x, y].flatMap((column) => /^([A-Z])\./.exec(column)?.[1] ?? []);
  const [first = ''] = letters;
  return letters.every((letter) => letter === first) ? first : '';
}

/** The same pair of another variant. */
export function ofVariant(pair: Pair, variant: string): Pair {
  return pair.map((column) => column.replace(/^[A-Z]\./, `${variant}.`)) as [string, string];
}

/** A channel without the variant: `Friction x`. */
export const quantityName = (column: string) => channelName(column).replace(/ of [A-Z]$/, '');

const OTHERS: readonly Look[] = [
  { ink: 'reference' },
  { ink: 'phase-b' },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-c', dash: 'dot' },
];

/** Curves of pairs: a variant's in its colour; others in neutral ones. */
export function pairSeries(pairs: readonly Pair[], { columns }: Sampled): Series[] {
  const values = new Map(columns.map((column) => [column.name, column.values]));
  return pairs.map((pair, i) => {
    const variant = variantOf(pair);
    const { ink = 'reference', dash = 'solid' } = variant
      ? looksOf(variant)
      : (OTHERS[i % OTHERS.length] as Look);
    return {
      name: variant || `${channelName(pair[1])} over ${channelName(pair[0])}`,
      x: values.get(pair[0]) ?? [],
      y: values.get(pair[1]) ?? [],
      ink,
      dash,
      width: variant === 'B' ? 1.8 : 1.2,
    };
  });
}
