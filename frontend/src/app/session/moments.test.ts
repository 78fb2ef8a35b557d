import { expect, it } from 'vitest';
import { gathered } from './moments.svelte';

it('gathers the changes of a drag into one, at its end', () => {
  const drag = [1, 1.4, 1.9, 2.6].map((time, k) => ({ time, set: { k_p: k } }));
  const later = { time: 4, set: { k_d: 1 } };
  expect(gathered([...drag, later], 1)).toEqual([{ time: 2.6, set: { k_p: 3 } }, later]);
  const both = gathered(
    [
      { time: 1, set: { k_p: 1 } },
      { time: 1.5, set: { k_d: 2 } },
    ],
    1,
  );
  expect(both).toEqual([{ time: 1.5, set: { k_p: 1, k_d: 2 } }]);
});
