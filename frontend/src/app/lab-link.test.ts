import { afterEach, describe, expect, it, vi } from 'vitest';
import { withChanges } from './api/scenario-paths';
import type { Changes, Scenario } from './api/types';
import { linkedSession, sessionParameters, settingsOf } from './lab-link';

const shipped = {
  name: 'circle',
  seed: 1,
  plant: { name: 'nominal', x: { mass: 5, friction: { F_c: 0.2 } } },
  trajectory: { kind: 'circle', radius: 0.015, lead_in: null },
  variants: { B: { label: 'b', controller: { x: { k_p: 2e5, notch: null } } } },
} as unknown as Scenario;

/** Opens the address that a session is written as. */
function opened(parameters: Record<string, string>) {
  const url = new URL('http://lab.test/');
  for (const [key, value] of Object.entries(parameters)) url.searchParams.set(key, value);
  vi.stubGlobal('location', new URL(url.href));
  return linkedSession();
}

afterEach(() => vi.unstubAllGlobals());

describe('the address of the Lab', () => {
  it.each<[string, Changes]>([
    ['nothing', {}],
    ['numbers deep inside', { seed: 7, 'variants.B.controller.x.k_p': 312e3 }],
    ['a part that was none', { 'variants.B.controller.x.notch': { frequency: 250 } }],
    ['another path', { trajectory: { kind: 'line', end: [0, 1] } }],
    ['none where there was a value', { 'plant.x.mass': null }],
  ])('carries %s', (_, changes) => {
    const scenario = withChanges(shipped, changes);
    const set = settingsOf(shipped, scenario);
    expect(set).toEqual(changes);
    const draft = { 'plant.x.friction.F_c': 0.3 };
    const linked = { scenario: 'circle', set: set ?? {}, draft };
    expect(opened(sessionParameters(linked))).toEqual(linked);
  });
  it('carries a scenario of its own as a whole', () => {
    const linked = { scenario: shipped, set: {}, draft: {} };
    expect(opened(sessionParameters(linked))).toEqual(linked);
  });
  it('is refused where it is damaged', () => {
    expect(() => opened({ scenario: 'circle', set: '{' })).toThrow();
    expect(() => opened({ scenario: 'circle', set: '[1]' })).toThrow();
  });
});
