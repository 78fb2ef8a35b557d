import { expect, it } from 'vitest';
import { exampleLanes } from './example-lanes';
import { packLanes, readLanes } from './lanes';
import { resultOf } from './result';
import type { RunResult } from './tasks';

const run = (itae: number | null, diverged: RunResult['diverged'] = null): RunResult => ({
  diverged,
  windows: [{ axes: { x: { itae } }, contour: { max: 1, rms: 1 } }],
  curves: [],
  loops: null,
});

it('an answer is read as it was packed', () => {
  const lanes = exampleLanes();
  expect(readLanes(packLanes(lanes))).toEqual(lanes);
  const known = { ...lanes, inputs: null, tables: null };
  expect(readLanes(packLanes(known))).toEqual(known);
});

it('a document has identity, window, variants, comparison and segments', () => {
  const result = resultOf(exampleLanes(), [run(2), run(3)]);
  expect(result).toMatchObject({
    scenario: 'example',
    window: { start: 1, end: 5 },
    comparison: { x: { itae_ratio: 1.5 } },
  });
  expect(result.variants.B).toMatchObject({ notes: ['as planned'], axes: { x: { itae: 3 } } });
  expect(result.segments).toHaveLength(1);
});

it('what diverged says so, and is compared with nothing', () => {
  const end = { time: 1.5, channel: 'x.following_error', last_states: [] };
  const { variants, comparison } = resultOf(exampleLanes(), [run(0), run(null, end)]);
  expect(variants.B?.notes[0]).toBe('diverged at t = 1.5000 s: x.following_error');
  expect(comparison).toEqual({ x: { itae_ratio: null } });
  expect(resultOf(exampleLanes(), [run(0), run(1)]).comparison).toEqual({
    x: { itae_ratio: null },
  });
});
