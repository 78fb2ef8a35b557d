import { expect, test } from 'vitest';
import { headline, reversalTable, type AxisGlitches } from './reversal-rows';

const ALIGNED = { start: -0.02, step: 0.0005, mean: [], low: [], high: [] };

function row(time: number, direction: number, height: number, delay: number | null) {
  return { time, direction, height, delay, rise: delay, duration: delay };
}

const AXIS: AxisGlitches = {
  count: 50e-9,
  variants: {
    A: {
      rows: [row(1.5, -1, -29.5e-6, 0.0145), row(3, 1, 30.1e-6, 0.015)],
      mean: { height: 29.8e-6, delay: 0.01475, rise: null, duration: 0.07 },
      aligned: ALIGNED,
    },
    B: {
      rows: [row(3, 1, 0.05e-6, null)],
      mean: { height: 0.05e-6, delay: null, rise: null, duration: null },
      aligned: ALIGNED,
    },
  },
};

test('a row has every variant, each in the unit of its heights', () => {
  const { units, rows, means } = reversalTable(AXIS, ['A', 'B']);
  expect(units).toEqual(['µm', 'nm']);
  expect(rows).toEqual([
    {
      time: 1.5,
      turn: '+ −',
      cells: [
        ['−29.5', '14.5', '14.5', '14.5'],
        ['', '', '', ''],
      ],
    },
    {
      time: 3,
      turn: '− +',
      cells: [
        ['30.1', '15.0', '15.0', '15.0'],
        ['50.0', '–', '–', '–'],
      ],
    },
  ]);
  expect(means).toEqual([
    ['29.8', '14.8', '–', '70.0'],
    ['50.0', '–', '–', '–'],
  ]);
});

test('the headline says it of each variant that has one', () => {
  expect(headline(AXIS, ['A', 'B'])).toBe('Glitch 29.8 µm under A, 50.0 nm under B');
  expect(headline(AXIS, ['A', 'C'])).toBe('Glitch 29.8 µm under A');
});
