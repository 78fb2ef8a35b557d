import { expect, it } from 'vitest';
import type { RunDetail, RunEvent } from '../../app/api/types';
import { asItRan } from './as-it-ran';

const K_P = 'variants.B.controller.x.k_p';
const K_D = 'variants.B.controller.x.k_d';

function run(...events: object[]): RunDetail {
  const scenario_document = { name: 'circle', schedule: [] };
  return { scenario_document, period: 0.0005, events } as unknown as RunDetail;
}

const change = (tick: number, set: object): object => ({ kind: 'change', tick, set }) as RunEvent;

it('has changes at their ticks, those of one tick together, and those of the start at once', () => {
  const stop = { kind: 'stop', tick: 5000 };
  const request = asItRan(
    run(change(0, { [K_P]: 1 }), change(700, { [K_P]: 2 }), change(700, { [K_D]: 3 }), stop),
  );
  expect(request.set).toEqual({ [K_P]: 1 });
  expect(request.scenario.schedule).toEqual([{ time: 700 * 0.0005, set: { [K_P]: 2, [K_D]: 3 } }]);
  expect(request.whole).toBe(true);
});

it('keeps the schedule of the scenario, over a change that came before it', () => {
  const ran = run(change(700, { [K_P]: 2 }));
  const event = { time: 1, set: { [K_D]: 3 } };
  Object.assign(ran.scenario_document ?? {}, { schedule: [event] });
  const made = { time: 700 * 0.0005, set: { [K_P]: 2 } };
  expect(asItRan(ran).scenario.schedule).toEqual([event, made]);
});

it('says where there are more changes than a schedule holds', () => {
  const many = Array.from({ length: 101 }, (_, i) => change(i + 1, { [K_P]: i }));
  expect(asItRan(run(...many))).toMatchObject({ set: {}, whole: false });
  expect(asItRan(run(...many)).scenario.schedule).toEqual([]);
  expect(asItRan(run(...many.slice(1))).whole).toBe(true);
});
