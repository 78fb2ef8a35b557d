/** Every sample of some columns over a stretch of a what-if or of a live session. */

import type { Range, SampleSource } from '../../plot/source';
import { readAnswer } from '../../app/api/curves-answer';
import { app } from '../../app/store.svelte';
import type { Changes, Scenario } from '../../app/api/types';

/** Most samples of a column: that many ticks a what-if answers with. */
export const MOST = 20_000;

export interface Sampled {
  period: number;
  start: number;
  columns: { name: string; values: (number | null)[] }[];
}

/** The end of a range, so long that it holds no more than the most samples. */
export function lastOf({ from, to }: Range, period: number): Range {
  return { from: Math.max(from, to - (MOST - 1) * period), to };
}

/** Simulates a stretch and returns every tick of it. */
export async function simulated(
  { scenario, set }: { scenario: Scenario; set: Changes },
  names: readonly string[],
  range: Range,
  signal: AbortSignal,
): Promise<Sampled> {
  const body = { scenario, set, columns: names, points: MOST, exact: true };
  const stretch = { start: range.from, end: range.to };
  const { source, period } = readAnswer(await app.api.whatif({ ...body, ...stretch }, signal));
  return { ...samplesOf(source, names, 0, source.last), period };
}

/** Samples [first, stop) of a source that has every tick. */
export function samplesOf(
  source: SampleSource,
  names: readonly string[],
  first: number,
  stop: number,
): Sampled {
  const count = Math.max(0, stop - first);
  const [low, high] = [new Float32Array(count), new Float32Array(count)];
  const columns = names.map((name) => {
    source.reduce(name, { first, size: 1, count, paired: false }, low, high);
    return { name, values: Array.from(low, (value) => (Number.isFinite(value) ? value : null)) };
  });
  return { period: source.step, start: source.start + first * source.step, columns };
}
