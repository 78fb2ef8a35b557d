/** The form of a search for gains and of a map of the cost, and their requests. */

import type { RequestOf } from '../../app/api/operations';
import { at } from '../../app/api/scenario-paths';
import type { Axis, Changes, Value } from '../../app/api/types';
import type { ScenarioSource } from '../../app/jobs/job-request';
import { marginLimits } from '../../parts/loop/loops.svelte';
import { nested, ScenarioForm } from '../../study/study-form.svelte';
import { clean } from '../../ui/units';

/** A weight for each metric of the objective that counts. */
export type Weights = Readonly<Record<string, number>>;

/** The motor that gains are judged on besides the scenario's own: the fit to the paper's errors. */
export const ALSO_ON = 'matched';

const OBSERVER = 'disturbance_observer.bandwidth';
const OBSERVER_RANGE = [5, 300]; // Hz
/** What a landscape is asked for too. */
const OF_BOTH = /^(axis|objective|bounds|plants|window)(\.|$)/;

export class SearchForm extends ScenarioForm {
  /** Whose gains are tuned. */
  readonly controller = $derived.by(() => this.text('variant'));
  readonly weights = $derived.by(() => this.value('objective') as Weights);
  /** Part of the run that is judged, s; null: what suits the motion. */
  readonly window = $derived.by((): readonly [number, number] | null => {
    const [start, end] = [this.number('window.start'), this.number('window.end')];
    return start === null || end === null ? null : [start, end];
  });

  readonly axes = $derived.by((): readonly Axis[] => {
    const axis = this.text('axis');
    return axis === 'x' || axis === 'y' ? [axis] : ['x', 'y'];
  });

  /** Whether the controller has a disturbance observer, whose bandwidth could be searched. */
  readonly observes = $derived.by(
    () =>
      at(this.scenario, `variants.${this.controller}.controller.disturbance_observer.enabled`) ===
      true,
  );

  /** Whether the observer's bandwidth is searched too. */
  readonly observer = $derived.by(() => OBSERVER in ((this.value('also') ?? {}) as object));

  gains(name: 'k_p' | 'k_d'): readonly [number, number] {
    return this.value(`bounds.${name}`) as unknown as readonly [number, number];
  }

  searchObserver(searched: boolean): void {
    this.change({ also: searched ? { [OBSERVER]: OBSERVER_RANGE } : {} });
  }

  judge(window: readonly [number, number] | null): void {
    const [start, end] = window ?? [];
    if (start === undefined || end === undefined) this.reset(['window.start', 'window.end']);
    else this.change({ 'window.start': start, 'window.end': end });
  }

  tuneBody(question: ScenarioSource): RequestOf<'/tune'> {
    const also = this.observer && this.observes ? this.value('also') : {};
    return { ...question, ...this.body(), variant: this.controller, also } as RequestOf<'/tune'>;
  }

  landscapeBody(question: ScenarioSource): RequestOf<'/landscape'> {
    const common = Object.entries(this.entered).filter(([path]) => OF_BOTH.test(path));
    const tables = nested(Object.fromEntries(common));
    return { ...question, ...tables, variant: this.controller, points: 64 };
  }

  override put(entered: Changes): void {
    super.put(entered);
    marginLimits.take(entered);
  }

  protected override usual(path: string): Value {
    return path === 'also' ? {} : super.usual(path);
  }
}

/** A gain margin in decibels, and back. */
export const decibels = (factor: number): number => clean(20 * Math.log10(factor));
export const factorOf = (dB: number): number => clean(10 ** (dB / 20));

/** Summary of the request of a search or a map. */
export function describe(request: Record<string, unknown>): string {
  const { axis = 'both', objective = { rms: 1 }, scenario = 'circle' } = request;
  const name = typeof scenario === 'string' ? scenario : (scenario as { name: string }).name;
  const axes = axis === 'both' ? 'x, y' : (axis as string);
  return `${name} ${axes}: ${Object.keys(objective as object).join(' + ')}`;
}
