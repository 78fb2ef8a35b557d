import { expect, it } from 'vitest';
import type { RunDetail } from '../../app/api/types';
import { commandsOf, linkTo, withoutCommands } from './recipe';

const ORIGIN = 'http://127.0.0.1:8000';
const GAIN = { path: 'variants.B.controller.x.k_p', shipped: 200_300, value: 312_000 };
const run = {
  id: 'r-abcdefghijkl',
  kind: 'simulation',
  scenario: 'circle',
  differences: [GAIN],
  scenario_document: { name: 'circle' },
} as unknown as RunDetail;
const of = (changes: Partial<RunDetail>) => commandsOf({ ...run, ...changes }, ORIGIN, ['circle']);

it('a simulation of a shipped scenario is set by its differences', () => {
  const { CLI, curl, Python, TOML } = of({});
  expect(CLI).toBe('motionlab run circle --set variants.B.controller.x.k_p=312000');
  expect(curl).toContain(`-d '{"scenario":"circle","set":{"variants.B.controller.x.k_p":312000}}'`);
  expect(Python).toContain(`web.Request("${ORIGIN}/api/v1/simulate"`);
  expect(TOML).toBe('base = "circle"\nvariants.B.controller.x.k_p = 312000\n');
});

it('another motor is not one value: only the whole scenario gives the same numbers', () => {
  const differences = [{ path: 'plant.name', shipped: 'nominal', value: 'matched' }];
  for (const other of [{ differences }, { scenario: 'mine', differences: [] }]) {
    const ways = of(other);
    expect(Object.keys(ways)).toEqual(['Python']);
    expect(ways.Python).toContain('scenario_document');
  }
});

it('what was changed while it ran has no such form', () => {
  expect(of({ kind: 'live' })).toEqual({});
  expect(of({ kind: 'measurement', scenario_document: null })).toEqual({});
  expect(withoutCommands({ kind: 'live' })).not.toBe('');
  expect(withoutCommands({ kind: 'measurement' })).not.toBe('');
  expect(withoutCommands(run)).toBe('');
});

it('a link holds nothing but the screen and the run', () => {
  const here = new URL('http://host:8000/?session=s&mode=live');
  expect(linkTo(['r-a', 'r-b'], here)).toBe('http://host:8000/?screen=runs&run=r-a,r-b');
});
