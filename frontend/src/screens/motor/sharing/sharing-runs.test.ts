import { describe, expect, it } from 'vitest';
import type { MapFit, SharingDocument } from '../../../app/api/types';
import {
  curvesOf,
  phasesOf,
  requests,
  ROWS,
  smooth,
  type Run,
  type SharingChoice,
  rowTexts,
} from './sharing-runs';

const choice: SharingChoice = {
  machines: ['new-design', 'previous-design'],
  laws: ['least-norm', 'sine'],
  belief: 'same',
};
const SET = { force: 20, overlap: 0.1 };

const answer = {
  law: 'sine',
  controller: { tau: 0.008 },
  thrust: { mean: 20, peak_to_peak: 1, rms: 0.3, relative: 0.05 },
  curves: {
    position: [0, 0.002, 0.004],
    current: [
      [1, 2, 3],
      [4, 5, 6],
      [7, 8, 9],
    ],
    thrust: [20, 20.5, 19.5],
  },
} as unknown as SharingDocument;

describe('requests', () => {
  it('are one for each machine and law, on its own map', () => {
    const all = requests(choice, SET, new Map());
    expect(all.map(({ machine, law }) => `${machine} ${law}`)).toEqual([
      'new-design least-norm',
      'new-design sine',
      'previous-design least-norm',
      'previous-design sine',
    ]);
    expect(all[0]?.body).toEqual({
      controller: 'new-design',
      law: 'least-norm',
      overlap: 0.1,
      force: 20,
    });
  });

  it('give the controller the fit and leave the plant its map', () => {
    const fit = { force_map: { F_pk: 38 } } as unknown as MapFit;
    const [first, , third] = requests(
      { ...choice, belief: 'fit' },
      SET,
      new Map([['new-design', fit]]),
    );
    expect(first?.body).toMatchObject({ controller: { F_pk: 38 }, plant: 'new-design' });
    // The analytic motor needs no fit.
    expect(third?.body).toMatchObject({ controller: 'previous-design' });
  });
});

describe('curves', () => {
  const runs: Run[] = [
    { machine: 'new-design', law: 'sine', answer },
    { machine: 'previous-design', law: 'sine', answer },
  ];

  it('go over the share of the pole pitch and differ by more than colour', () => {
    const [first, second] = curvesOf(runs, 'thrust');
    expect(Array.from(first?.x ?? [])).toEqual([0, 0.25, 0.5]);
    expect(first?.name).toBe('sine, new-design');
    expect(first?.width).not.toBe(second?.width);
  });

  it('tell laws apart by colour and by dash', () => {
    const [sine, cubic] = curvesOf(
      [runs[0] as Run, { machine: 'new-design', law: 'cubic', answer }],
      'thrust',
    );
    expect(sine?.ink).not.toBe(cubic?.ink);
    expect(sine?.dash).not.toBe(cubic?.dash);
  });

  it('know where there is no ripple to see', () => {
    expect(smooth(runs)).toBe(false);
    const flat = { ...answer, thrust: { ...answer.thrust, peak_to_peak: 0.004 } };
    expect(smooth([{ machine: 'new-design', law: 'sine', answer: flat }])).toBe(true);
  });

  it('have one machine named once', () => {
    expect(curvesOf(runs.slice(0, 1), 'thrust')[0]?.name).toBe('sine');
  });

  it('show three phases', () => {
    expect(phasesOf(runs[0] as Run, 'current').map(({ name, y }) => [name, y[0]])).toEqual([
      ['a', 1],
      ['b', 4],
      ['c', 7],
    ]);
  });
});

it('ripple is in per cent of the mean', () => {
  const row = ROWS.find(({ name }) => name === 'ripple/mean');
  expect(row?.value(answer)).toBeCloseTo(5);
});

it('writes a row with the same decimals throughout', () => {
  expect(rowTexts([4.787, 5.02])).toEqual(['4.787', '5.020']);
  expect(rowTexts([41.99, null, -3.1])).toEqual(['41.99', '–', '−3.10']);
  expect(rowTexts([0.0132, 0.002])).toEqual(['0.013', '0.002']);
  expect(rowTexts([0, 0])).toEqual(['0', '0']);
});
