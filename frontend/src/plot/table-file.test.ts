import { describe, expect, it } from 'vitest';
import { AxisScale } from './axis-scale';
import { StillSource } from './source';
import { csvOf, shownTable, tabbed, tableOf } from './table-file';

const scale = (label: string, unit: string) => new AxisScale({ label, unit }, 0, 1, [0, 100]);

describe('numbers of a plot', () => {
  it('are the samples of a source, least and largest where bins hold several', () => {
    const low = Float32Array.of(-1e-6, 0.1, Number.NaN, 4);
    const source = new StillSource(
      10,
      0.5,
      4,
      new Map([
        ['e', { minimum: low, maximum: low }],
        ['f', { minimum: low, maximum: Float32Array.of(0, 1, Number.NaN, 5) }],
      ]),
    );
    const traces = [
      { label: 'A', column: 'e', unit: 'm' },
      { label: 'flag, "B"', column: 'f', unit: '1' },
      { label: 'C', column: 'missing', unit: 'm' },
    ];
    const csv = csvOf(tableOf({ source, range: { from: 10, to: 11.4 }, traces }));
    expect(csv.split('\r\n')).toEqual([
      'time [s],A [m],"flag, ""B"" least","flag, ""B"" largest"',
      '10,-0.000001,-0.000001,0',
      '10.5,0.1,0.1,1',
      '11,,,',
      '11.5,4,4,5',
      '',
    ]);
  });
  it('are all points of curves at their places, in SI', () => {
    const table = tableOf({
      series: [
        { name: 'one', x: [1, 2], y: [0.1, 0.2] },
        { name: 'two', x: [2, 3], y: [5, null], error: [1, 1] },
      ],
      bands: [],
      x: scale('speed', 'm/s'),
      y: scale('force', 'N'),
    });
    expect(table).toEqual([
      ['speed [m/s]', 'one [N]', 'two [N]', 'two, from [N]', 'two, to [N]'],
      [1, 0.1, null, null, null],
      [2, 0.2, 5, 4, 6],
      [3, null, null, null, null],
    ]);
  });
  it('are one row for each cell of a map', () => {
    const [x, y, z] = [scale('k_p', 'N/m'), scale('k_d', 'N s/m'), scale('cost', '1')];
    const table = tableOf({ xs: [1, 2], ys: [3], rows: [[7, null]], x, y, z });
    expect(tabbed(table)).toBe('k_p [N/m]\tk_d [N s/m]\tcost\n1\t3\t7\n2\t3\t');
  });
  it('are those of a table as shown, with signs that programs read', () => {
    const columns = [
      { name: 'time', unit: 's', cells: ['1', 'most'] },
      { name: 'e', unit: 'µm', cells: ['−2.5', '–'] },
    ];
    expect(csvOf(shownTable(columns))).toBe('time [s],e [µm]\r\n1,-2.5\r\nmost,\r\n');
    const formulas = shownTable([{ name: '=1+1', unit: 'V', cells: ['@x', '\u22122+x', '−2'] }]);
    expect(csvOf(formulas)).toBe("'=1+1 [V]\r\n'@x\r\n'-2+x\r\n-2\r\n");
    expect(tabbed(formulas)).toBe("'=1+1 [V]\n'@x\n'-2+x\n-2");
  });
});
