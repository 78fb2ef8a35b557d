import { expect, it, vi } from 'vitest';
import { exampleLanes } from '../../kernel/example-lanes';
import type { Lanes } from '../../kernel/lanes';
import type { Changes, Scenario, Value } from '../api/types';
import { changedLanes, Beyond, type LaneCode } from './changed-lanes';
import { LaneChanges, type Numbers } from './lane-changes';
import { PATIENCE } from './loading';
import { Refused } from './refused-changes';

vi.mock('./changed-lanes', async (original) => ({
  ...(await original<object>()),
  changedLanes: vi.fn((_: unknown, lanes: Lanes) => ({ ...lanes, lanes: Float64Array.of(1) })),
}));

const scenario = { plant: { name: 'nominal', mass: 1 }, seed: 1 } as unknown as Scenario;
const question = (set: Changes, of = scenario) => ({ scenario: of, set, columns: [] });

/** What the server has checked: `set`, on lanes with a change. */
function made(set: Changes, lanes: Partial<Lanes> = {}, parts: Record<string, Value> = {}) {
  const changes = new LaneChanges(
    () => parts,
    () => Promise.resolve({} as LaneCode),
  );
  changes.take(question(set), { lanes: { ...exampleLanes(), ...lanes } } as Numbers);
  return changes;
}

it('makes lanes from those of the question that the server has checked', async () => {
  const changes = made({ 'plant.mass': 2 });
  const numbers = await changes.lanesOf(question({ 'plant.mass': 3 }), null);
  expect(numbers?.lanes.lanes).toEqual(Float64Array.of(1));
  const [, , before, changed] = vi.mocked(changedLanes).mock.lastCall as unknown[];
  expect([before, changed]).toMatchObject([{ plant: { mass: 2 } }, { plant: { mass: 3 } }]);
});

it('leaves to the server what differs in more than the changes, or is beyond the page', async () => {
  const changes = made({});
  expect(await changes.lanesOf(question({}, { ...scenario }), null)).not.toBeNull();
  expect(await changes.lanesOf(question({}, { ...scenario, seed: 2 }), null)).toBeNull();
  vi.mocked(changedLanes).mockImplementationOnce(() => {
    throw new Beyond();
  });
  expect(await changes.lanesOf(question({}), null)).toBeNull();
  vi.mocked(changedLanes).mockImplementationOnce(() => {
    throw new Refused([]);
  });
  await expect(changes.lanesOf(question({}), null)).rejects.toBeInstanceOf(Refused);
});

it('leaves parts to the server that it does not know', async () => {
  const set = { plant: 'heavy' };
  const parts = { 'plant=heavy': { name: 'heavy', mass: 9 } };
  expect(await made({}).lanesOf(question(set), null)).toBeNull();
  expect(await made(set).lanesOf(question({}), null)).toBeNull();
  expect(await made({}, {}, parts).lanesOf(question(set), null)).not.toBeNull();
});

it('starts from a stored state with changes of a running session, and no further than it goes', async () => {
  const changes = made({}, { how: 'window', first: 4, stop: 10, period: 0.5 });
  const mass = question({ 'plant.mass': 3 });
  expect(await changes.lanesOf(mass, null)).not.toBeNull();
  expect(await changes.lanesOf(mass, { from: 2, to: 5 })).not.toBeNull();
  expect(await changes.lanesOf(mass, { from: 1, to: 5 })).toBeNull();
  expect(await changes.lanesOf(question({ seed: 2 }), null)).toBeNull();
});

it('asks the server while the code takes long to load', async () => {
  vi.useFakeTimers();
  const changes = new LaneChanges(undefined, () => new Promise(() => undefined));
  changes.take(question({}), { lanes: exampleLanes() } as Numbers);
  const lanes = changes.lanesOf(question({}), null);
  await vi.advanceTimersByTimeAsync(PATIENCE);
  expect(await lanes).toBeNull();
  vi.useRealTimers();
});

it('asks the server where the code cannot be loaded', async () => {
  const changes = new LaneChanges(undefined, () => Promise.reject(new Error('gone')));
  changes.take(question({}), { lanes: exampleLanes() } as Numbers);
  expect(await changes.lanesOf(question({}), null)).toBeNull();
});
