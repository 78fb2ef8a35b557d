import { expect, it } from 'vitest';
import { AxisScale } from './axis-scale';
import { recorder } from './recorder';
import { drawBand, tracePath } from './series-drawing';

const x = new AxisScale({ label: 'x', unit: 'm' }, 0, 10, [0, 100]);
const y = new AxisScale({ label: 'y', unit: 'N' }, 0, 10, [100, 0]);

it('a line leaves a gap where a value is missing', () => {
  const { canvas, calls } = recorder();
  tracePath(canvas, { x: [0, 1, 2, 3, 4], y: [1, 2, null, Number.NaN, 4] }, x, y);
  expect(calls.slice(1)).toEqual([
    ['moveTo', 0, 90],
    ['lineTo', 10, 80],
    ['moveTo', 40, 60],
  ]);
});

it('steps hold their value until the next', () => {
  const { canvas, calls } = recorder();
  tracePath(canvas, { x: [0, 1], y: [1, 2], kind: 'step' }, x, y);
  expect(calls.slice(1)).toEqual([
    ['moveTo', 0, 90],
    ['lineTo', 10, 90],
    ['lineTo', 10, 80],
  ]);
});

it('a band is cut at its gaps', () => {
  const { canvas, calls } = recorder();
  const band = { name: 'b', x: [0, 1, 2, 3, 4], low: [0, 0, null, 0, 0], high: [1, 1, 1, 1, 1] };
  drawBand(canvas, band, x, y);
  expect(calls.filter(([name]) => name === 'closePath')).toHaveLength(2);
  expect(calls.filter(([name]) => name === 'lineTo')).toHaveLength(6);
});
