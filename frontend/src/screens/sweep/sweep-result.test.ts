import { expect, it } from 'vitest';
import type { SweepResult } from '../../app/api/types';
import { valuesOf } from './figures';
import { axisOf, bestOf, caseOf, csvOf, curvesOf, mapOf } from './sweep-result';

const MASS = { path: 'plant.x.mass', unit: 'kg', values: [7, 5, 6] };
const MOTOR = { path: 'plant', unit: '', values: ['nominal', 'matched'] };

function resultOf(fields: SweepResult['fields'], shape: number[], values: (number | null)[]) {
  const axes = { x: { metrics: { peak: values } } };
  const variants = { B: { label: 'b', diverged: [], axes } };
  return { fields, shape, cases: values.length, variants } as unknown as SweepResult;
}

it('a grid has a case for each combination, the last field fastest', () => {
  const grid = resultOf([MASS, MOTOR], [3, 2], [1, 2, 3, 4, 5, 6]);
  expect([0, 1, 5].map((i) => caseOf(grid, i))).toEqual([
    [7, 'nominal'],
    [7, 'matched'],
    [6, 'matched'],
  ]);
  const { xs, cases } = mapOf(grid, axisOf(MASS).at, axisOf(MOTOR).at);
  expect(xs).toEqual([5, 6, 7]);
  expect(cases).toEqual([
    [2, 4, 0],
    [3, 5, 1],
  ]);
});

it('a list takes values together', () => {
  const list = resultOf([MASS, { ...MOTOR, values: ['a', 'b', 'c'] }], [3], [1, 2, 3]);
  expect(caseOf(list, 1)).toEqual([5, 'b']);
});

it('curves run upwards, with gaps where a case has no number', () => {
  const one = resultOf([MASS], [3], [1, null, 3]);
  const [curve] = curvesOf(one, 'x', 'peak', axisOf(MASS).at);
  expect(curve).toMatchObject({ name: 'B', x: [5, 6, 7], y: [null, 3, 1] });
  expect(curvesOf(one, 'y', 'peak', axisOf(MASS).at)).toEqual([]);
  expect(bestOf(valuesOf(one, 'B', 'x', 'peak'))).toBe(0);
  expect(bestOf([null, null])).toBe(-1);
});

it('names are numbered, and told in the name of the axis', () => {
  expect(axisOf(MOTOR)).toMatchObject({ at: [1, 2] });
  expect(axisOf(MOTOR).axis.label).toContain('2 matched');
});

it('the file has a row for each case, and quotes what needs it', () => {
  const odd = resultOf([{ ...MOTOR, values: ['a,b', 'c'] }], [2], [0.5, null]);
  expect(csvOf(odd)).toBe('case,plant,B.x.peak\n0,"a,b",0.5\n1,c,\n');
  const formula = resultOf([{ ...MOTOR, values: ['=1+1', '-x'] }], [2], [-0.5, 1]);
  expect(csvOf(formula)).toContain("0,'=1+1,-0.5\n1,'-x,1\n");
});
