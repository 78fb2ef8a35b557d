import { expect, it } from 'vitest';
import type { LawEntry, Scenario } from '../../../app/api/types';
import { costText, lawWithVersions, oldAgainstNew, versionText } from './law-versions';

const law = (more: Partial<LawEntry>) =>
  ({
    name: 'mine',
    before: '',
    version: 1,
    versions: 1,
    newer: false,
    problem: '',
    ...more,
  }) as LawEntry;

const controller = (law: string, k_p: number) => ({
  controller: { name: 'own', x: { k_p, notch: { gain: 1 } }, compensation: { law, share: 1 } },
});

const scenario = { variants: { A: controller('off', 1), B: controller('mine', 2) } };

it('says which version runs, and what it costs', () => {
  expect(versionText(law({}))).toBe('');
  expect(versionText(law({ version: 3, versions: 4, newer: true }))).toBe(
    'Version 3 of 4 runs; the file is newer.',
  );
  expect(versionText(law({ versions: 2, newer: true, problem: 'no' }))).toBe(
    'Version 1 of 2 runs.',
  );
  expect(costText({ ns: 41.7, share: 8.34e-5 })).toBe(
    'It costs 42 ns in a tick, 0.0083 % of the control period.',
  );
});

it('has A run the version before with all that B has', () => {
  const own = law({ before: 'mine@before' });
  const changes = oldAgainstNew(scenario as unknown as Scenario, ['A', 'B'], 'B', own);
  expect(changes).toEqual({
    'variants.A.controller.x.k_p': 2,
    'variants.A.controller.compensation.law': 'mine@before',
  });
});

it('takes the law in use that has other versions, also by its version before', () => {
  const laws = [law({ name: 'off' }), law({ versions: 2, before: 'mine@before' })];
  const of = (A: string, B: string) =>
    lawWithVersions(laws, {
      variants: { A: controller(A, 1), B: controller(B, 1) },
    } as unknown as Scenario)?.name;
  expect(of('off', 'mine')).toBe('mine');
  expect(of('mine@before', 'off')).toBe('mine');
  expect(of('off', 'off')).toBeUndefined();
});
