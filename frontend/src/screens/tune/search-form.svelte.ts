/** The form of a search for gains and of a map of the cost, and their requests. */

import type { RequestOf } from '../../app/api/operations';
import { at } from '../../app/api/scenario-paths';
import type { Axis, Changes, ProblemField, Value } from '../../app/api/types';
import {
  choicesOf,
  entryOf,
  fieldOf,
  lawParameters,
  refusalText,
} from '../../app/fields/fields.svelte';
import type { ScenarioSource } from '../../app/jobs/job-request';
import { marginLimits } from '../../parts/loop/loops.svelte';
import { nested, ScenarioForm } from '../../study/study-form.svelte';
import { clean } from '../../ui/units';

/** A weight for each metric of the objective that counts. */
export type Weights = Readonly<Record<string, number>>;

/** Low and high of a number that is searched, SI. */
export type Ends = [number, number];

/** The motor that gains are judged on besides the scenario's own: the fit to the paper's errors. */
export const ALSO_ON = 'matched';

const OBSERVER = 'disturbance_observer.bandwidth';
const OBSERVER_RANGE: Ends = [5, 300]; // Hz
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

  /** Numbers that the controller uses beside its gains, by path below it: they can be searched. */
  readonly further = $derived.by((): readonly string[] => {
    const ofLaw = lawParameters(this.scenario, this.controller)
      .filter((path) => choicesOf(path).length === 0)
      .map((path) => path.slice(this.whole('').length));
    return at(this.scenario, this.whole('disturbance_observer.enabled')) === true
      ? [...ofLaw, OBSERVER]
      : ofLaw;
  });

  /** Those that are searched, with their ranges. */
  readonly also = $derived.by((): Readonly<Record<string, Ends>> => {
    const entered = (this.value('also') ?? {}) as Record<string, Ends>;
    return Object.fromEntries(
      Object.entries(entered).filter(([path]) => this.further.includes(path)),
    );
  });

  gains(name: 'k_p' | 'k_d'): Ends {
    return this.value(`bounds.${name}`) as Ends;
  }

  /** The path in the scenario of a path below the controller. */
  whole(path: string): string {
    return `variants.${this.controller}.controller.${path}`;
  }

  /** Searches a further number in a range, by default its usual one; null: no longer. */
  search(path: string, ends: Ends | null = this.usualEnds(path)): void {
    const others = Object.entries(this.also).filter(([other]) => other !== path);
    this.change({ also: Object.fromEntries(ends ? [...others, [path, ends]] : others) });
  }

  /** The search is in logarithms: its ranges begin above zero. */
  private usualEnds(path: string): Ends {
    if (path === OBSERVER) return OBSERVER_RANGE;
    const { usual, bounds } = entryOf(this.whole(path)) ?? {};
    const most = bounds?.maximum ?? bounds?.exclusive_maximum ?? 1;
    const [low, high] = usual ?? [bounds?.minimum ?? bounds?.exclusive_minimum ?? 0, most];
    return [low > 0 ? low : high / 1000, high];
  }

  judge(window: readonly [number, number] | null): void {
    const [start, end] = window ?? [];
    if (start === undefined || end === undefined) this.reset(['window.start', 'window.end']);
    else this.change({ 'window.start': start, 'window.end': end });
  }

  tuneBody(question: ScenarioSource): RequestOf<'/tune'> {
    const { controller: variant, also } = this;
    return { ...question, ...this.body(), variant, also } as RequestOf<'/tune'>;
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

  /** A further number is named, and its values are in the unit of the screen. */
  protected override refusal(problem: ProblemField): string {
    const [, path] = /^also\.([^.]+\.[^.]+)/.exec(problem.loc) ?? [];
    if (path === undefined) return super.refusal(problem);
    const field = fieldOf(this.whole(path));
    return `${field.label}: ${refusalText(problem, field)}`;
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
