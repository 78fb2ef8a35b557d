import { expect, it } from 'vitest';
import type { Scenario } from '../api/types';
import { carriedGains, replacedText, lostPaths, type ReplacedSession } from './replaced-session';

function scenario(name: string, gains: Record<string, number>, mass = 5.9): Scenario {
  const controller = { x: { k_p: gains.A ?? 1 } };
  const other = { x: { k_p: gains.B ?? 1, k_d: gains.d ?? 1 } };
  return {
    name,
    plant: { name: 'nominal', x: { mass } },
    variants: { A: { controller }, B: { controller: other } },
  } as unknown as Scenario;
}

const B = 'variants.B.controller.x';

function left(draft: ReplacedSession['draft'] = {}): ReplacedSession {
  const base = scenario('circle', {});
  const changed = scenario('circle', { B: 619e3 }, 6.5);
  return { base, scenario: changed, draft, drafts: [], paths: [], speed: 1, mode: 'live' };
}

it('names what was changed since the scenario was loaded, and what waits in what-if', () => {
  const all = left({ [`${B}.k_d`]: 2900, [`${B}.k_p`]: 700e3 });
  expect(lostPaths(all)).toEqual(['plant.x.mass', `${B}.k_p`, `${B}.k_d`]);
  expect(replacedText(all)).toBe(
    'circle was left with 3 changes, 2 of them staged: plant x mass, B kp x, B kd x.',
  );
  expect(replacedText(left())).toBe('circle was left with 2 changes: plant x mass, B kp x.');
  const untouched = { ...left(), scenario: scenario('circle', {}) };
  expect(lostPaths(untouched)).toEqual([]);
});

it('carries gains over to another scenario, not its motor, and only where they differ', () => {
  const all = left({ [`${B}.k_d`]: 2900, 'variants.C.controller.x.k_p': 5 });
  const to = scenario('rhombus', { B: 200e3 });
  expect(carriedGains(all, to)).toEqual({ [`${B}.k_p`]: 619e3, [`${B}.k_d`]: 2900 });
  expect(carriedGains(all, scenario('rhombus', { B: 619e3, d: 2900 }))).toEqual({});
});
