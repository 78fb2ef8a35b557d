/** The result document of a run in the page, as the server makes it of one of its own. */

import type { LanesHead, WindowHead } from './lanes';
import type { Figures } from './metrics';
import type { Divergence, RunResult, WindowFigures } from './tasks';

interface VariantResult extends WindowFigures {
  label: string;
  law: string;
  enabled: boolean;
  notes: readonly string[];
  diverged: Divergence | null;
}

export interface WindowResult {
  /** s */
  window: { start: number; end: number };
  variants: Record<string, VariantResult>;
  comparison: Record<string, Figures>;
}

export interface Result extends WindowResult {
  segments: WindowResult[];
}

/**
 * Returns the document of one run of each variant, in their order.
 *
 * Warnings, such as of a loop that is unstable, are the server's: here a variant's notes say that it
 * diverged, and what is known without a run.
 */
export function resultOf(head: LanesHead, runs: readonly RunResult[]): Result {
  const windows = head.windows.map((window, i) => windowOf(head, window, runs, i));
  const [main] = windows;
  if (!main) throw new Error('there is no window');
  const segments = head.segments.map((i) => windows[i] as WindowResult);
  return { ...head.result, ...main, segments };
}

function windowOf(
  { period, ratios }: LanesHead,
  { start, end, variants: heads }: WindowHead,
  runs: readonly RunResult[],
  index: number,
): WindowResult {
  const results = Object.entries(heads).map(([name, head], i) => {
    const { diverged, windows } = runs[i] as RunResult;
    const warnings = diverged
      ? [`diverged at t = ${diverged.time.toFixed(4)} s: ${diverged.channel}`]
      : [];
    const figures = windows[index] as WindowFigures;
    return [name, { ...head, notes: [...warnings, ...head.notes], diverged, ...figures }] as const;
  });
  const [a, b] = results;
  return {
    window: { start: start * period, end: end * period },
    variants: Object.fromEntries(results),
    comparison: a && b ? compared(a[1], b[1], ratios) : {},
  };
}

/** B against A; null where one of them is missing or A is zero. */
function compared(a: WindowFigures, b: WindowFigures, ratios: readonly string[]) {
  const axes = Object.entries(a.axes).map(([axis, ofA]) => {
    const ofB = b.axes[axis as keyof typeof b.axes] ?? {};
    const figures = ratios.map((metric) => {
      const [below, above] = [ofA[metric] ?? null, ofB[metric] ?? null];
      const ratio = below === null || above === null || below === 0 ? null : above / below;
      return [`${metric}_ratio`, ratio !== null && Number.isFinite(ratio) ? ratio : null] as const;
    });
    return [axis, Object.fromEntries(figures)] as const;
  });
  return Object.fromEntries(axes);
}
