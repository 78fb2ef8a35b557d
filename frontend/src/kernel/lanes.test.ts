import { expect, it } from 'vitest';
import { exampleLanes } from './example-lanes';
import { packLanes, readLanes } from './lanes';

it('keeps numbers and texts of any length, in any script', () => {
  for (const label of ['', 'a', 'ab', 'µ', 'µµ', '摩擦']) {
    const lanes = { ...exampleLanes(), result: { label } };
    expect(readLanes(packLanes(lanes)), label).toEqual(lanes);
  }
});
