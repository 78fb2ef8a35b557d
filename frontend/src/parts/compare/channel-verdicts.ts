/** Verdicts of a comparison in words, in order, and as a file. */

import type { ChannelComparison, Comparison, Place } from '../../app/api/types';
import { digits, percent, prettyUnit, type Scale, scaleFor } from '../../ui/units';
import { csvRow } from '../../ui/export';
import type { Column as TableColumn } from '../../plot/table-columns';
import type { ComparisonWindow, CurveName } from './comparison-window';

export type Verdict = ChannelComparison['verdict'];

interface Said {
  name: string;
  sign: string;
  look: 'good' | 'bad' | 'warn';
}

/** The gravest first. Only `within` is a pass. */
export const VERDICTS: Readonly<Record<Verdict, Said>> = {
  'out-of-tolerance': { name: 'out of tolerance', sign: '✗', look: 'bad' },
  'not-aligned': { name: 'not aligned', sign: '?', look: 'warn' },
  'ranges-differ': { name: 'ranges differ', sign: '?', look: 'warn' },
  'units-differ': { name: 'units differ', sign: '?', look: 'warn' },
  missing: { name: 'missing', sign: '?', look: 'warn' },
  empty: { name: 'empty', sign: '?', look: 'warn' },
  within: { name: 'within', sign: '✓', look: 'good' },
};
const ORDER = Object.keys(VERDICTS) as Verdict[];

/** How many channels have each verdict that occurs, the gravest first. */
export function countsOf(channels: readonly ChannelComparison[]): [Verdict, number][] {
  return ORDER.map((verdict): [Verdict, number] => [
    verdict,
    channels.filter((channel) => channel.verdict === verdict).length,
  ]).filter(([, count]) => count > 0);
}

/** The verdict on all, as a sentence. */
export function headlineOf({ headline, holds }: Comparison) {
  return { text: `${headline.charAt(0).toUpperCase()}${headline.slice(1)}.`, holds };
}

export const COLUMNS = [
  { key: 'name', name: 'channel', title: 'Name of the channel' },
  { key: 'tolerance', name: 'tolerance', title: 'max(absolute, relative × |1|), in time' },
  { key: 'largest', name: '2 − 1', title: 'Where the runs are farthest apart' },
  { key: 'at', name: 'at', title: 'Where that is first' },
  { key: 'beyond', name: 'beyond', title: 'Share of the instants beyond the tolerance' },
  { key: 'rms', name: 'rms', title: 'Root mean square of the difference' },
  { key: 'verdict', name: 'verdict', title: 'The gravest first' },
] as const;
export type Column = (typeof COLUMNS)[number]['key'];

export interface Sorting {
  /** Null in the order of the channels. */
  by: Column | null;
  down: boolean;
}

/** As the server lists them among equals. */
export const GRAVEST_FIRST: Sorting = { by: 'verdict', down: false };

const size = (value: number | null) =>
  value === null ? Number.NEGATIVE_INFINITY : Math.abs(value);

const KEYS: Readonly<Record<Column, (channel: ChannelComparison) => number | string>> = {
  name: ({ name }) => name,
  tolerance: ({ tolerance }) => Math.max(tolerance.absolute, tolerance.relative),
  largest: ({ largest }) => size(largest),
  at: ({ at }) => at?.time ?? Number.POSITIVE_INFINITY,
  beyond: ({ beyond }) => size(beyond),
  rms: ({ rms }) => size(rms),
  verdict: ({ verdict }) => ORDER.indexOf(verdict),
};

/** Returns the channels to list, of one verdict or all. */
export function listed(
  channels: readonly ChannelComparison[],
  verdict: Verdict | '',
  { by, down }: Sorting,
): ChannelComparison[] {
  const some = channels.filter((channel) => verdict === '' || channel.verdict === verdict);
  if (by === null) return some;
  const key = KEYS[by];
  return some.sort((a, b) => {
    const [one, other] = [key(a), key(b)];
    const order = one < other ? -1 : one > other ? 1 : 0;
    return down ? -order : order;
  });
}

/** The order after a click on a column: once, the other way round, none. Sizes begin with the largest. */
export function sortedBy({ by, down }: Sorting, column: Column): Sorting {
  const first = ['largest', 'beyond', 'rms', 'tolerance'].includes(column);
  if (by !== column) return { by: column, down: first };
  return down === first ? { by, down: !first } : { by: null, down: false };
}

/** The unit in which a channel's row is written. */
export function scaleOf({
  unit,
  candidate_unit: other,
  largest,
  tolerance,
}: ChannelComparison): Scale {
  return scaleFor(
    largest === null || largest === 0 ? tolerance.absolute : largest,
    unit ?? other ?? '1',
  );
}

export function toleranceText({ tolerance }: ChannelComparison, scale: Scale): string {
  const { absolute, relative, time } = tolerance;
  const parts = [
    ...(absolute > 0 || relative === 0
      ? [absolute > 0 ? `±${short(absolute * scale.factor)}` : '0']
      : []),
    ...(relative > 0 ? [`${short(100 * relative)} %`] : []),
    ...(time > 0 ? [`${short(1000 * time)} ms`] : []),
  ];
  return parts.join(', ');
}

/** Two digits are enough of a tolerance, none of them a needless zero. */
function short(value: number): string {
  return String(Number(value.toPrecision(value < 1 ? 2 : 3)));
}

/** Where something is: time, or lap and arc length. */
export function placeText(place: Place | null): string {
  if (place === null) return '';
  if (place.lap === null || place.arc === null) return `${digits(place.time, 5)} s`;
  return `lap ${place.lap + 1}, ${digits(1000 * place.arc, 4)} mm`;
}

export function beyondText(share: number | null): string {
  if (share === null) return '';
  return share > 0 && share < 0.0005 ? '<0.1 %' : percent(share).replace('+', '');
}

/** Says why a channel has no figures. */
export function reasonText({ verdict, unit, candidate_unit: other }: ChannelComparison): string {
  if (verdict === 'missing') return unit === null ? 'only in 2' : 'only in 1';
  if (verdict === 'units-differ') return `${unitText(unit)} and ${unitText(other)}`;
  return VERDICTS[verdict].name;
}

function unitText(unit: string | null): string {
  return unit === '1' ? 'no unit' : prettyUnit(unit ?? '?');
}

/** The table as a file: SI, a decimal point, nothing where there is no figure. */
export function csvOf({ channels }: Comparison): string {
  const head =
    'channel,unit,verdict,tolerance_absolute,tolerance_relative,tolerance_time_s,interpolation,' +
    'largest,time_1_s,time_2_s,lap,arc_m,beyond_share,rms,compared,single';
  const lines = channels.map((one) => {
    const { tolerance, at } = one;
    const unit =
      one.verdict === 'units-differ' ? `${one.unit} and ${one.candidate_unit}` : one.unit;
    return csvRow([
      one.name,
      unit ?? one.candidate_unit,
      one.verdict,
      tolerance.absolute,
      tolerance.relative,
      tolerance.time,
      one.interpolation,
      one.largest,
      at?.time,
      at?.candidate_time,
      at?.lap,
      at?.arc,
      one.beyond,
      one.rms,
      one.compared,
      one.single,
    ]);
  });
  return [head, ...lines, ''].join('\n');
}

/** More rows than these could not be read. */
const MOST = 100;
const HEADS: Readonly<Record<CurveName, string>> = {
  baseline: '1',
  candidate: '2',
  difference: '2 − 1',
  tolerance: 'tolerance',
  beyond: 'beyond',
};
const PLACES = { time: 'time of 1', reference: 'arc length', index: 'sample' };

/** Returns what is drawn as numbers: of each bin the value that is larger in size. */
export function columnsOf(window: ComparisonWindow): { columns: TableColumn[]; thinned: boolean } {
  const every = Math.max(1, Math.ceil(window.x.length / MOST));
  const rows = Array.from({ length: Math.ceil(window.x.length / every) }, (_, i) => i * every);
  const { axis } = window;
  const place = {
    name: PLACES[axis.name],
    unit: axis.unit === '1' ? '' : axis.unit,
    cells: rows.map((i) => digits(window.x[i] ?? Number.NaN, 6)),
  };
  const columns = (Object.keys(HEADS) as CurveName[]).map((name) => {
    const { minimum, maximum } = window.curve(name);
    const values = rows.map((i) => larger(minimum[i] ?? Number.NaN, maximum[i] ?? Number.NaN));
    if (name === 'beyond') {
      return {
        name: HEADS[name],
        unit: '',
        cells: values.map((value) => (value === 1 ? 'yes' : '')),
      };
    }
    const size = Math.max(0, ...values.filter(Number.isFinite).map(Math.abs));
    const scale = scaleFor(size, window.unit);
    const cells = values.map((value) => digits(value * scale.factor, 4));
    return { name: HEADS[name], unit: scale.unit, cells };
  });
  return { columns: [place, ...columns], thinned: every > 1 };
}

function larger(low: number, high: number): number {
  return Math.abs(low) > Math.abs(high) ? low : high;
}
