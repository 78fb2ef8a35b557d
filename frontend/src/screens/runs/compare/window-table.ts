/** The table twin of a comparison's curves. */

import type { Column } from '../../../plot/table-columns';
import { digits, scaleFor } from '../../../ui/units';
import type { ComparisonWindow, CurveName } from './comparison-window';

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
export function columnsOf(window: ComparisonWindow): { columns: Column[]; thinned: boolean } {
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
