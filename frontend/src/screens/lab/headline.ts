/** The result in one line, and what A and B are in one sentence. */

import { difference, numberAt, withChanges } from '../../app/api/scenario-paths';
import {
  AXES,
  type Axis,
  type Changes,
  type Metrics,
  type Scenario,
  type SessionInfo,
} from '../../app/api/types';
import { fieldOf, show } from '../../app/fields/fields.svelte';
import { digits, quantity, type Scale, scaleFor } from '../../ui/units';

export interface Headline {
  /** Whose figure leads; empty where there is none. */
  variant: string;
  /** `0.25 µm`, or what there is instead of it. */
  figure: string;
  /** ` on x, 99 % less than A`: what follows the figure, the axis where there are two. */
  rest: string;
  /** What is measured: `max |e_x|`; empty without a figure. */
  measure: string;
  /** Largest errors of first and second variant, m; null where there is none. */
  sizes: readonly (number | null)[];
  /** The unit in which both sizes are given. */
  texts: readonly string[];
  bad: boolean;
}

/** Two variants count as equal within this share. */
const SAME = 0.005;

function nothing(figure: string, bad = false): Headline {
  return { variant: '', figure, rest: '', measure: '', sizes: [], texts: [], bad };
}

/**
 * Returns the headline of a result: the largest following error of the last variant with one, on the
 * axis on which it is largest, against that of the first one on the same axis.
 */
export function headline(
  metrics: Metrics | null,
  shown: readonly string[],
  diverged: Readonly<Record<string, number>>,
  waiting: string,
): Headline {
  const [a = '', last = a] = shown;
  const gone = shown.filter((name) => name in diverged);
  const when = (name: string) => `${digits(diverged[name] ?? 0)} s`;
  if (gone.includes(last)) {
    const both = gone.length > 1 && gone.length === shown.length;
    return both
      ? nothing(
          `${shown.join(' and ')} are unstable: the runs ended at ${gone.map(when).join(' and ')}`,
          true,
        )
      : { ...nothing(`is unstable: its run ended at ${when(last)}`, true), variant: last };
  }
  const sizeOf = (variant: string, axis: Axis) =>
    metrics?.variants[variant]?.axes[axis]?.max_abs_following_error ?? null;
  // On a drive the first one runs before the last one.
  const b = AXES.some((each) => sizeOf(last, each) !== null) ? last : a;
  const axis = AXES.reduce<Axis | null>((worst, each) => {
    const size = sizeOf(b, each);
    if (size === null) return worst;
    return worst === null || size > (sizeOf(b, worst) ?? 0) ? each : worst;
  }, null);
  if (axis === null) return nothing(waiting);
  const [before, size] = [a === b ? null : sizeOf(a, axis), sizeOf(b, axis) ?? 0];
  const sizes = a === b ? [size] : [before, size];
  const scale = scaleFor(Math.max(size, before ?? 0), 'm');
  // With the next change the other axis may be the worse one.
  const both = AXES.every((each) => sizeOf(b, each) !== null);
  const on = both ? ` on ${axis}` : '';
  return {
    variant: b,
    figure: sizeText(size, scale),
    rest: `${on}${restOf(a, b, before, size, a in diverged ? when(a) : '')}`,
    measure: `max |e_${axis}|`,
    sizes,
    texts: sizes.map((each) =>
      each === null ? '–' : `${digits(each * scale.factor)} ${scale.unit}`,
    ),
    bad: false,
  };
}

/** Writes a size in the unit of both, as the metrics do: 0.25 µm beside 20.5 µm, not 251 nm. */
function sizeText(size: number, { factor, unit }: Scale): string {
  const shown = size * factor;
  if (shown !== 0 && shown < 0.01) {
    const own = quantity(size, 'm');
    return `${own.number} ${own.unit}`;
  }
  return `${digits(shown, shown < 1 ? 2 : 3)} ${unit}`;
}

function restOf(a: string, b: string, before: number | null, size: number, ended: string): string {
  if (a === b) return '';
  if (ended !== '') return `; ${a} is unstable, its run ended at ${ended}`;
  if (before === null || before === 0) return '';
  const ratio = size / before;
  if (Math.abs(ratio - 1) < SAME) return `, as ${a} has`;
  if (ratio >= 2) return `, ${digits(ratio, 2)} times that of ${a}`;
  const share = Math.abs(ratio - 1) * 100;
  return `, ${percentage(share)} % ${ratio < 1 ? 'less' : 'more'} than ${a}`;
}

/** Whole per cent, but never 100 of what is not all of it. */
function percentage(share: number): string {
  if (share > 99.5 && share < 100) return (Math.floor(share * 10) / 10).toFixed(1);
  return share < 10 ? digits(share, 2) : share.toFixed(0);
}

/** Differences that a sentence names; more are counted. */
const NAMED = 2;

/** Whether anything of a scenario is random. */
function noisy(scenario: Scenario): boolean {
  const own = AXES.flatMap((axis) =>
    ['encoder', 'amplifiers'].map((part) => numberAt(scenario, `plant.${axis}.${part}.noise`)),
  );
  return [...own, numberAt(scenario, 'load.noise')].some((size) => size > 0);
}

/** What a variant's controller does about friction. */
function lawOf(scenario: Scenario, variant: string): string {
  const controller = scenario.variants[variant]?.controller;
  const law = controller?.compensation.law ?? 'off';
  const path = `variants.${variant}.controller.compensation.law`;
  if (law === 'off') return 'without friction compensation';
  if (controller?.compensation.enabled === false) return 'with friction compensation switched off';
  return `with friction compensation (${show(path, law)})`;
}

/** The scenario once everything that is planned has happened, and when the first of that changes a controller, s. */
export function inTheEnd(scenario: Scenario): { scenario: Scenario; since: number | null } {
  const planned = [...scenario.schedule].sort((a, b) => a.time - b.time);
  const first = planned.find(({ set }) => Object.keys(set).some((path) => CONTROLLER.test(path)));
  const end = planned.reduce((so, { set }) => withChanges(so, set as Changes), scenario);
  return { scenario: end, since: first?.time ?? null };
}

const CONTROLLER = /^variants\.[A-Z]\.controller\./;

/** Says in a sentence what the variants shown are, and in the end, from what they really differ in. */
export function sentence(begun: Scenario, shown: readonly string[]): string {
  const { scenario, since } = inTheEnd(begun);
  const [a, b] = shown;
  if (a === undefined) return '';
  const later = since === null ? '' : `from ${Number(since.toPrecision(6))} s on `;
  if (b === undefined) return `One motor: ${later}${a} ${lawOf(scenario, a)}.`;
  const noise = noisy(scenario) ? ', with the same noise' : '';
  const [first, end] = [begun, scenario].map((each) => differing(each, a, b));
  const then = first === '' || since === null ? '' : `${first}; `;
  const same = `${a} and ${b} have the same controller`;
  return `Same motor and motion${noise}: ${then}${later}${end || same}.`;
}

/** What two variants differ in; empty where they have the same controller. */
function differing(scenario: Scenario, a: string, b: string): string {
  const [first, second] = [a, b].map((name) => scenario.variants[name]?.controller ?? {});
  const paths = difference(first ?? {}, second ?? {})
    .map(({ path }) => path)
    .filter((path) => !['name', 'title', 'description'].includes(path));
  if (paths.length === 0) return '';
  const laws = [a, b].map((name) => lawOf(scenario, name));
  const others = paths.filter((path) => !/^compensation\.(law|enabled)$/.test(path));
  const names = [
    ...new Set(others.map((path) => fieldOf(`variants.${b}.controller.${path}`).label)),
  ];
  const more = names.length - NAMED;
  const listed = names.slice(0, more === 1 ? NAMED + 1 : NAMED).join(', ');
  const list = more > 1 ? `${listed} and ${more} more` : listed;
  if (laws[0] === laws[1]) return `${a} and ${b} differ in ${list}`;
  const also = list === '' ? '' : `; ${list} ${names.length > 1 ? 'differ' : 'differs'} too`;
  const both = laws.every((law) => law.startsWith('with '));
  const other = both ? laws[1]?.replace(/friction compensation \((.*)\)|friction /, '$1') : laws[1];
  return `${a} ${laws[0]}, ${b} ${other}${also}`;
}

/** `time` is what has been recorded of the motion, s: nothing on the way to its start. */
export function driveEmptyText(
  variant: string,
  state: SessionInfo['state'] | undefined,
  time: number,
): string {
  if (time > 0) {
    return state === 'playing'
      ? `${variant} moves on the drive: no result yet`
      : `${variant} ended on the drive without a result`;
  }
  return state === 'playing'
    ? `${variant} moves to its start on the drive; curves begin there.`
    : `${variant} ended on the drive before its start.`;
}
