/** Lane parameters with other values of fields that are copied into them. */

import type { Axis, Lanes } from '../kernel/lanes';
import { AXES, LANES } from '../kernel/module';

/** A field whose value is a parameter as it is. */
interface CopiedField {
  variant: number;
  axis: Axis;
  row: number;
  minimum: number;
  maximum: number;
}

/** Lanes of a run in a report. */
export interface ReportLanes extends Lanes {
  copies: Record<string, CopiedField>;
  /** Of the prediction of each row of inputs. */
  orders: number[];
}

/**
 * Returns lane parameters with other values of copied fields; null where a field is no copy, or a value
 * is out of its range.
 */
export function withFields(
  { lanes, epochs, tabled, copies }: ReportLanes,
  values: Iterable<readonly [path: string, value: unknown]>,
): Float64Array | null {
  const numbers = lanes.slice();
  const variants = tabled.length;
  const rows = numbers.length / (epochs.length * variants * LANES);
  for (const [path, value] of values) {
    const field = copies[path];
    if (!field || typeof value !== 'number') return null;
    const { variant, axis, row, minimum, maximum } = field;
    if (!(value >= minimum && value <= maximum)) return null;
    for (let epoch = 0; epoch < epochs.length; epoch++) {
      const place = (epoch * variants + variant) * rows + row;
      numbers[place * LANES + AXES.indexOf(axis)] = value;
    }
  }
  return numbers;
}
