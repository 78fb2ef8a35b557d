/** What a motion cost, as tables. */

import { percent } from '../../ui/units';
import type { Axis } from '../../app/api/types';
import { row, type Row } from './rows';
import type { DocumentOf } from './views-api';

type Cost = DocumentOf<'cost'>;

type AxisCost = Cost['variants'][string][string];
type Ratios = NonNullable<AxisCost['ratios']>;

const FIGURES: readonly [keyof Ratios, string, string, string][] = [
  ['copper', 'copper loss', 'Integral of the squared currents: joules for each ohm', 'J/Ω'],
  ['current_peak', 'peak current', 'Of all phases', 'A'],
  ['current_rms', 'RMS current', 'Of the phase where it is largest', 'A'],
  ['thrust_work', 'work of thrust', 'Force times velocity, over the stretch', 'J'],
  ['friction_work', 'work against friction', 'Friction times velocity, over the stretch', 'J'],
  ['force_peak', 'peak thrust', 'Largest magnitude', 'N'],
  ['force_rms', 'RMS thrust', 'Over time', 'N'],
  ['force_rate', 'effort', 'RMS rate of the force command', 'N/s'],
  ['saturated', 'saturated', 'Share of time with a force or a current at its limit', '%'],
];

const BALANCE = [
  ['thrust', 'thrust', 'Work of the thrust'],
  ['friction', '− friction', 'Work against friction'],
  ['load', '− load', 'Work against load and pushes'],
  ['kinetic', '− kinetic', 'Kinetic energy gained'],
  ['residual', '= residual', 'What sums over samples leave; 0 in continuous time'],
] as const;

const PHASES = ['a', 'b', 'c'] as const;

/** Figures of one axis, with the change of the second variant from the first. */
export function figureRows(cost: Cost, names: readonly string[], axis: Axis): Row[] {
  const ones = names.map((name) => cost.variants[name]?.[axis]);
  return FIGURES.map(([key, name, title, unit]) => {
    const scale = unit === '%' ? 100 : 1;
    const values = ones.map((one) => scaled(one?.[key], scale));
    const made = row(name, title, unit, values);
    const changes = ones.slice(1).map((one) => {
      const ratio = one?.ratios?.[key];
      return percent(ratio === null || ratio === undefined ? null : ratio - 1);
    });
    return { ...made, cells: [...made.cells, ...changes] };
  });
}

export function phaseRows(cost: Cost, names: readonly string[], axis: Axis): Row[] {
  const ones = names.map((name) => cost.variants[name]?.[axis]);
  return PHASES.flatMap((phase) =>
    (['rms', 'peak'] as const).map((key) => {
      const title = `Current of phase ${phase}`;
      const values = ones.map((one) => one?.phases[phase]?.[key] ?? null);
      const made = row(`${phase} ${key === 'rms' ? 'RMS' : key}`, title, 'A', values);
      const worst = (i: number) => key === 'rms' && ones[i]?.worst_phase === phase;
      return { ...made, cells: made.cells.map((cell, i) => (worst(i) ? `worst ${cell}` : cell)) };
    }),
  );
}

export function balanceRows(cost: Cost, names: readonly string[], axis: Axis): Row[] {
  const balances = names.map((name) => cost.variants[name]?.[axis]?.balance ?? null);
  if (balances.every((one) => one === null)) return [];
  return BALANCE.map(([key, name, title]) =>
    row(
      name,
      title,
      'J',
      balances.map((one) => one && one[key]),
    ),
  );
}

/** Channels that the recording lacks, of the variants shown. */
export function missing(cost: Cost, names: readonly string[]): string[] {
  const all = names.flatMap((name) =>
    Object.values(cost.variants[name] ?? {}).flatMap((one) => one.missing),
  );
  return [...new Set(all)];
}

function scaled(value: number | null | undefined, factor: number): number | null {
  return value === null || value === undefined ? null : value * factor;
}
