/** The rows of the metrics table: which number, its name, unit and definition. */

import { among, scaleFor, type Scale } from '../../ui/units';
import type { Axis, AxisMetrics, Metrics, VariantMetrics } from '../api/types';
import { AXES } from '../api/types';

interface Definition<Key extends string = keyof AxisMetrics> {
  key: Key;
  /** Name with `$` for the axis. */
  name: string;
  unit: string;
  meaning: string;
  /** Shown at once; the others on demand. */
  main?: boolean;
  /** Whether less is better; of the others the table makes no judgement. */
  less?: boolean;
  /** Lines that share a unit, so that their numbers compare down the column too. */
  group?: 'following' | 'hold';
}

const DEFINITIONS: readonly Definition[] = [
  {
    key: 'max_abs_following_error',
    name: 'max |e_$|',
    unit: 'm',
    meaning: 'largest following error: reference less measured position',
    main: true,
    less: true,
    group: 'following',
  },
  {
    key: 'rms_following_error',
    name: 'RMS e_$',
    unit: 'm',
    meaning: 'root mean square of the following error',
    main: true,
    less: true,
    group: 'following',
  },
  {
    key: 'itae',
    name: 'ITAE $',
    unit: 'm s^2',
    meaning: 'integral of time times |e|, from the start of the window',
    less: true,
  },
  {
    key: 'steady_state_error',
    name: 'steady e_$',
    unit: 'm',
    meaning: 'largest |e| over the last fifth of each hold',
    main: true,
    less: true,
    group: 'hold',
  },
  {
    key: 'settling_time',
    name: 'settling $',
    unit: 's',
    meaning:
      'from the end of command until |e| stays within the settling band, longest of all holds',
    main: true,
    less: true,
  },
  {
    key: 'overshoot',
    name: 'overshoot $',
    unit: 'm',
    meaning: 'how far the measured position goes past the target during a hold',
    less: true,
    group: 'hold',
  },
  {
    key: 'max_abs_velocity',
    name: 'peak |v_$|',
    unit: 'm/s',
    meaning: 'largest true speed',
  },
  {
    key: 'rms_force',
    name: 'RMS F_$',
    unit: 'N',
    meaning: 'root mean square of the true thrust',
  },
  {
    key: 'max_abs_force',
    name: 'peak F_$',
    unit: 'N',
    meaning: 'largest true thrust',
  },
  {
    key: 'max_current',
    name: 'peak i_$',
    unit: 'A',
    meaning: 'largest current of any phase',
    main: true,
  },
  {
    key: 'rms_current',
    name: 'RMS i_$',
    unit: 'A',
    meaning: 'root mean square of the three phase currents together',
  },
  {
    key: 'saturated_fraction',
    name: 'saturated $',
    unit: '1',
    meaning: 'share of ticks with the force or a current command at its limit',
    less: true,
  },
];

type ContourKey = 'max' | 'rms';

const CONTOUR: readonly Definition<ContourKey>[] = [
  {
    key: 'max',
    name: 'contour max',
    unit: 'm',
    meaning: 'largest distance from the measured position to the path',
    main: true,
    less: true,
    group: 'following',
  },
  {
    key: 'rms',
    name: 'contour RMS',
    unit: 'm',
    meaning: 'root mean square of that distance',
    less: true,
    group: 'following',
  },
];

export interface Row {
  name: string;
  unit: string;
  meaning: string;
  main: boolean;
  values: string[];
  /** Second variant against the first, a share; null where there is no such figure. */
  change: number | null;
  /** Whether the change is for the better; null without judgement. */
  better: boolean | null;
}

interface Line {
  definition: Definition<string>;
  axis: Axis | '';
  numbers: number[];
}

/** Returns the rows for the first two variants; those that nobody has a number for are left out. */
export function rows(metrics: Metrics, variants: readonly string[]): Row[] {
  const shown = variants.slice(0, 2).map((name) => metrics.variants[name]);
  const lines: Line[] = [];
  const add = (
    definition: Definition<string>,
    axis: Axis | '',
    values: (number | null | undefined)[],
  ) => {
    const numbers = values.map((value) => value ?? Number.NaN);
    if (numbers.some((number) => !Number.isNaN(number))) lines.push({ definition, axis, numbers });
  };
  for (const definition of DEFINITIONS.slice(0, 2)) {
    for (const axis of AXES) add(definition, axis, axisValues(shown, axis, definition.key));
  }
  for (const definition of CONTOUR) {
    add(
      definition,
      '',
      shown.map((variant) => variant?.contour[definition.key]),
    );
  }
  for (const definition of DEFINITIONS.slice(2)) {
    for (const axis of AXES) add(definition, axis, axisValues(shown, axis, definition.key));
  }
  return lines.map((line) => row(line, scaleOf(line, lines)));
}

/** Says which changes lie within the window, as its numbers are of both before and after. */
export function changesWithin({ start, end }: Metrics['window'], times: readonly number[]): string {
  const within = [...new Set(times.filter((time) => time > start && time < end))]
    .sort((a, b) => a - b)
    .map((time) => Number(time.toFixed(2)));
  const last = within.pop();
  if (last === undefined) return '';
  if (within.length === 0) return `Includes a change at ${last} s.`;
  if (within.length > 2) return `Includes ${within.length + 1} changes, the last at ${last} s.`;
  return `Includes changes at ${within.join(', ')} and ${last} s.`;
}

function axisValues(
  shown: readonly (VariantMetrics | undefined)[],
  axis: Axis,
  key: keyof AxisMetrics,
) {
  return shown.map((variant) => variant?.axes[axis]?.[key]);
}

/** The unit of a line: that of all lines of its group, or of both axes. */
function scaleOf({ definition }: Line, lines: readonly Line[]): Scale {
  const alike = lines.filter(({ definition: other }) =>
    definition.group ? other.group === definition.group : other === definition,
  );
  const sizes = alike.flatMap(({ numbers }) => numbers.filter(Number.isFinite).map(Math.abs));
  return scaleFor(Math.max(...sizes), definition.unit);
}

function row({ definition, axis, numbers }: Line, scale: Scale): Row {
  const [a = Number.NaN, b = Number.NaN] = numbers;
  const change = a !== 0 && Number.isFinite(b / a) ? b / a - 1 : null;
  const judged = definition.less === true && change !== null && Math.abs(change) >= 0.0005;
  return {
    name: definition.name.replace('$', axis),
    unit: scale.unit,
    meaning: definition.meaning,
    main: definition.main === true,
    values: numbers.map((value) => among(value, scale)),
    change,
    better: judged ? change < 0 : null,
  };
}
