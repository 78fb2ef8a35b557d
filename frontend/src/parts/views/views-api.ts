/** Calls of the views, and what they are of. */

import type { paths } from '../../app/api/schema';
import type { Changes, Scenario } from '../../app/api/types';
import { app } from '../../app/store.svelte';
import type { Range, SampleSource } from '../../plot/source';

/** Every view of the server. */
export type ViewName = keyof paths extends infer Path
  ? Path extends `/api/v1/views/${infer Name}`
    ? Name
    : never
  : never;

/** The document of a view. */
export type DocumentOf<Name extends ViewName> =
  paths[`/api/v1/views/${Name}`]['post']['responses'][200]['content']['application/json'];

/** A kept run or a scenario, and which stretch of it, s. */
export interface Subject {
  run?: string;
  scenario?: Scenario;
  set?: Changes;
  start?: number;
  end?: number;
}

/** A test cycle of positioning; what is left out is the server's. */
export interface Cycle {
  targets?: number;
  runs?: number;
  dwell?: number;
  low?: number | null;
  high?: number | null;
}

/** Returns the question of a view, for any subject. */
export const asks =
  <Name extends ViewName>(name: Name) =>
  (body: Subject) =>
    app.api.json('post', `/views/${name as ViewName}`, { body }) as Promise<DocumentOf<Name>>;

/** Most samples of a column: that many ticks a what-if answers with. */
export const MOST = 20_000;

export interface Sampled {
  period: number;
  start: number;
  columns: { name: string; values: (number | null)[] }[];
}

/** The end of a range, so long that it holds no more than the most samples. */
export function lastOf({ from, to }: Range, period: number, most = MOST): Range {
  return { from: Math.max(from, to - (Math.floor(most) - 1) * period), to };
}

/** Samples [first, stop) of a source that has every tick. */
export function samplesOf(
  source: Pick<SampleSource, 'start' | 'step' | 'reduce'>,
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
