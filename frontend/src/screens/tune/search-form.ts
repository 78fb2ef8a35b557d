/** The form of a search for gains, and its requests. */

import type { RequestOf } from '../../app/api/operations';
import { at } from '../../app/api/scenario-paths';
import type { components } from '../../app/api/schema';
import type { Axis, ProblemField, Scenario } from '../../app/api/types';
import type { ScenarioSource } from '../../app/jobs/job-request';
import { type Entries, fieldOf, nameOf, refusal, served } from '../../app/fields/fields.svelte';
import { listOf, nullOr, oneOf, partOf, recordOf } from '../../app/storage';
import { clean } from '../../ui/units';

type Schemas = components['schemas'];

/** A metric of the objective. */
export type Metric = keyof NonNullable<RequestOf<'/tune'>['objective']>;
export type Constraint = keyof Schemas['Constraints'];

export interface SearchForm {
  /** Name of a shipped scenario; empty: what the Lab's controls show. */
  source: string;
  /** Whose gains; empty: the second variant, or the only one. */
  variant: string;
  axis: Axis | 'both';
  /** Weights; a metric without one does not count. */
  weights: Partial<Record<Metric, number>>;
  /** Limits in SI; null: left out. */
  limits: Record<Constraint, number | null>;
  k_p: readonly [number, number];
  k_d: readonly [number, number];
  /** Bandwidth of the disturbance observer is searched too. */
  observer: boolean;
  /** Shipped motors on which the gains must do as well. */
  plants: readonly string[];
  /** Part of the run that is judged, s; null: what suits the motion. */
  window: readonly [number, number] | null;
  starts: number;
  evaluations: number;
}

/** The form of the settings that a browser keeps. */
export const KEPT = partOf({
  source: '',
  variant: '',
  axis: oneOf('x', 'y', 'both'),
  weights: recordOf(0),
  limits: recordOf(nullOr(0)),
  k_p: [0, 0],
  k_d: [0, 0],
  observer: true,
  plants: listOf(''),
  window: nullOr([0, 0]),
  starts: 0,
  evaluations: 0,
});

/** Fields of the request, which are there before the screen is. */
export function fields(): Entries {
  return served.requests.tune ?? {};
}

/** The motor that gains are judged on besides the scenario's own: the fit to the paper's errors. */
export const ALSO_ON = 'matched';

/** What the form begins with: what the server takes for what is left out, and a second motor. */
export function defaults(): SearchForm {
  return { ...left(), plants: [ALSO_ON] };
}

/** What a request means that leaves a setting out. */
export function left(): SearchForm {
  const of = (path: string) => fields()[path]?.default;
  const from = {
    axis: of('axis'),
    weights: of('objective'),
    limits: of('constraints'),
    k_p: of('bounds.k_p'),
    k_d: of('bounds.k_d'),
    plants: of('plants'),
    starts: of('starts'),
    evaluations: of('evaluations'),
  } as Pick<
    SearchForm,
    'axis' | 'weights' | 'limits' | 'k_p' | 'k_d' | 'plants' | 'starts' | 'evaluations'
  >;
  return { source: '', variant: '', observer: false, window: null, ...from };
}

export const OBSERVER = 'disturbance_observer.bandwidth';
/** Hz */
const OBSERVER_RANGE = [5, 300];

/** The variant that a form means, of those that a scenario has. */
export function variantOf(form: SearchForm, scenario: Scenario): string {
  const letters = Object.keys(scenario.variants);
  if (letters.includes(form.variant)) return form.variant;
  return letters[1] ?? letters[0] ?? '';
}

/** Whether a controller has a disturbance observer, whose bandwidth could be searched. */
export function observes(scenario: object, variant: string): boolean {
  return at(scenario, `variants.${variant}.controller.disturbance_observer.enabled`) === true;
}

interface Common extends ScenarioSource {
  variant: string;
  axis: SearchForm['axis'];
  objective: SearchForm['weights'];
  bounds: Pick<SearchForm, 'k_p' | 'k_d'>;
  plants: readonly string[];
  window: { start: number; end: number } | null;
}

/** Returns the fields common to requests of search and landscape. */
function common(form: SearchForm, source: ScenarioSource): Common {
  const { axis, weights, k_p, k_d, plants, window } = form;
  return {
    ...source,
    variant: variantOf(form, source.scenario),
    axis,
    objective: weights,
    bounds: { k_p, k_d },
    plants,
    window: window ? { start: window[0], end: window[1] } : null,
  };
}

export function tuneBody(
  form: SearchForm,
  source: ScenarioSource,
  shown: object,
): RequestOf<'/tune'> {
  const body = common(form, source);
  const also = form.observer && observes(shown, body.variant) ? { [OBSERVER]: OBSERVER_RANGE } : {};
  const { limits, starts, evaluations } = form;
  return { ...body, constraints: limits, also, starts, evaluations };
}

export function landscapeBody(form: SearchForm, source: ScenarioSource): RequestOf<'/landscape'> {
  return { ...common(form, source), points: 64 };
}

const OF_BOTH = ['variant', 'axis', 'objective', 'bounds', 'plants', 'window'];
const OF_SEARCH = ['constraints', 'also', 'starts', 'evaluations'];

/** Names of the settings of a landscape, or of a search, by their key in a request. */
export function settings(of: 'landscape' | 'search'): Record<string, string> {
  const keys = of === 'search' ? [...OF_BOTH, ...OF_SEARCH] : OF_BOTH;
  return Object.fromEntries(keys.map((key) => [key, fieldOf(key, fields()).label]));
}

/** Returns the form of a request of a search or a landscape, without its scenario. */
export function formOf(request: Readonly<Record<string, unknown>>): Partial<SearchForm> {
  const asked = request as Partial<Common> & {
    constraints?: Partial<SearchForm['limits']>;
    also?: object;
  } & Partial<Pick<SearchForm, 'plants' | 'starts' | 'evaluations'>>;
  const { bounds, window, constraints, also } = asked;
  const form: { [Key in keyof SearchForm]?: SearchForm[Key] | undefined } = {
    variant: asked.variant,
    axis: asked.axis,
    weights: asked.objective,
    limits: constraints && { ...defaults().limits, ...constraints },
    k_p: bounds?.k_p,
    k_d: bounds?.k_d,
    observer: also && OBSERVER in also,
    plants: asked.plants ?? [],
    window: window === undefined ? undefined : window && [window.start, window.end],
    starts: asked.starts,
    evaluations: asked.evaluations,
  };
  const said = Object.entries(form).filter(([, value]) => value !== undefined);
  return Object.fromEntries(said) as Partial<SearchForm>;
}

/** Writes an error of a request: which number, why, and the allowed range. */
export function complaint(problem: ProblemField): string {
  return [nameOf(problem.loc, fields()), refusal(problem, fields())].join(': ');
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
