import { expect, it } from 'vitest';
import { Memory, MemoryFull } from './memory';

it('grows with what is placed, aligned, up to its bound', () => {
  const memory = new Memory(1e6);
  const first = memory.put(Float64Array.of(1, 2, 3));
  const { mark } = memory;
  const second = memory.place(500_000);
  expect([first % 16, second % 16]).toEqual([0, 0]);
  expect(memory.bytes).toBeGreaterThan(500_000);
  // A view after growth still has what was put before.
  expect([...memory.float64(first, 3)]).toEqual([1, 2, 3]);
  memory.release(mark);
  expect(memory.place(8)).toBe(second);
  expect(() => memory.place(1_000_000)).toThrow(MemoryFull);
  expect(memory.bytes).toBeLessThanOrEqual(1e6 + 65_536);
});
