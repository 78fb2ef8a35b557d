import { expect, it } from 'vitest';
import { lookOf, readLook, takeLook } from './look';
import type { TimeView } from './time-view.svelte';

const usual = () => ({
  zoom: null as { from: number; to: number } | null,
  cursors: [] as number[],
  levels: {} as Record<number, number[]>,
  statistic: 'value',
  measuring: false,
});
const asView = (fields: object) => fields as unknown as TimeView;

it('what is as usual is not in the address', () => {
  expect(lookOf(asView(usual()))).toEqual({});
});

it('an address shows the same, by other times', () => {
  const view = {
    ...usual(),
    zoom: { from: 20.2, to: 20.4 },
    cursors: [20.25, 20.3],
    levels: { 0: [1e-6] },
    measuring: true,
    statistic: 'rms',
  };
  const elsewhere = usual();
  takeLook(asView(elsewhere), readLook(JSON.stringify(lookOf(asView(view), -20.2))));
  expect(elsewhere).toEqual({
    ...view,
    zoom: { from: 0, to: 0.2 },
    cursors: [0.05, 0.1],
  });
});

it('what is damaged is left out', () => {
  const view = usual();
  const damaged = '{"zoom":[3,1],"cursors":"x","levels":[null],"statistic":"?","measuring":1}';
  takeLook(asView(view), readLook(damaged));
  expect(view).toEqual({ ...usual(), levels: { 0: [] } });
});
