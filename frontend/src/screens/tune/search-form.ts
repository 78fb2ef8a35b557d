/** What the controls of a search for gains say, and what is asked of the server for it. */

import type { RequestOf } from '../../app/api/operations';
import { at } from '../../app/api/scenario-paths';
import type { Axis, ProblemField, Scenario } from '../../app/api/types';
import type { Source } from '../../app/jobs/job-request';
import { clean, digits, prettyUnit } from '../../ui/units';

export const METRICS = ['peak', 'rms', 'itae', 'settling', 'effort'] as const;
export type Metric = (typeof METRICS)[number];

/** What one unit of weight stands for, as the server has it. */
export const PER: Record<Metric, string> = {
  peak: 'µm',
  rms: 'µm',
  itae: 'µm s²',
  settling: '10 ms',
  effort: 'N',
};

export const CONSTRAINTS = ['gain_margin', 'phase_margin', 'Ms', 'saturated', 'force'] as const;
export type Constraint = (typeof CONSTRAINTS)[number];

export interface Form {
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

/** The server's own defaults. */
export const DEFAULT: Form = {
  source: '',
  variant: '',
  axis: 'both',
  weights: { rms: 1 },
  limits: { gain_margin: 2, phase_margin: 0.5236, Ms: null, saturated: 0, force: null },
  k_p: [1e4, 3e7],
  k_d: [1e2, 1e5],
  observer: false,
  plants: [],
  window: null,
  starts: 4,
  evaluations: 200,
};

/** What a constraint begins with when it is switched on. */
export const USUAL: Record<Constraint, number> = {
  gain_margin: 2,
  phase_margin: 0.5236,
  Ms: 2,
  saturated: 0,
  force: 30,
};

export const OBSERVER = 'disturbance_observer.bandwidth';
/** Hz */
const OBSERVER_RANGE = [5, 300];

/** The variant that a form means, of those that a scenario has. */
export function variantOf(form: Form, scenario: Scenario): string {
  const letters = Object.keys(scenario.variants);
  if (letters.includes(form.variant)) return form.variant;
  return letters[1] ?? letters[0] ?? '';
}

/** Whether a controller has a disturbance observer, whose bandwidth could be searched. */
export function observes(scenario: object, variant: string): boolean {
  return at(scenario, `variants.${variant}.controller.disturbance_observer.enabled`) === true;
}

interface Common extends Source {
  variant: string;
  axis: Form['axis'];
  objective: Form['weights'];
  bounds: Pick<Form, 'k_p' | 'k_d'>;
  window: { start: number; end: number } | null;
}

/** Returns what both the search and the landscape are asked for. */
function common(form: Form, source: Source): Common {
  const { axis, weights, k_p, k_d, window } = form;
  return {
    ...source,
    variant: variantOf(form, source.scenario),
    axis,
    objective: weights,
    bounds: { k_p, k_d },
    window: window ? { start: window[0], end: window[1] } : null,
  };
}

export function tuneBody(form: Form, source: Source, shown: object): RequestOf<'/tune'> {
  const body = common(form, source);
  const also = form.observer && observes(shown, body.variant) ? { [OBSERVER]: OBSERVER_RANGE } : {};
  const { limits, plants, starts, evaluations } = form;
  return { ...body, constraints: limits, also, plants, starts, evaluations };
}

export function landscapeBody(form: Form, source: Source): RequestOf<'/landscape'> {
  return { ...common(form, source), points: 64 };
}

/** Settings of a landscape, and further ones of a search, by their key in a request. */
export const SETTINGS = {
  landscape: {
    variant: 'controller',
    axis: 'axis',
    objective: 'objective',
    bounds: 'ranges of the gains',
    window: 'window',
  },
  search: {
    constraints: 'limits',
    also: 'observer',
    plants: 'motors',
    starts: 'starts',
    evaluations: 'evaluations',
  },
};

/** Returns what a search or a landscape was asked for as the form shows it; not its scenario. */
export function formOf(request: Readonly<Record<string, unknown>>): Partial<Form> {
  const asked = request as Partial<Common> & {
    constraints?: Partial<Form['limits']>;
    also?: object;
  } & Partial<Pick<Form, 'plants' | 'starts' | 'evaluations'>>;
  const { bounds, window, constraints, also } = asked;
  const form: { [Key in keyof Form]?: Form[Key] | undefined } = {
    variant: asked.variant,
    axis: asked.axis,
    weights: asked.objective,
    limits: constraints && { ...DEFAULT.limits, ...constraints },
    k_p: bounds?.k_p,
    k_d: bounds?.k_d,
    observer: also && OBSERVER in also,
    plants: asked.plants,
    window: window === undefined ? undefined : window && [window.start, window.end],
    starts: asked.starts,
    evaluations: asked.evaluations,
  };
  const said = Object.entries(form).filter(([, value]) => value !== undefined);
  return Object.fromEntries(said) as Partial<Form>;
}

const NAMES: Record<string, string> = {
  'bounds.k_p': 'range of k_p',
  'bounds.k_d': 'range of k_d',
  objective: 'objective',
  'objective.settling': 'settling',
  'constraints.gain_margin': 'gain margin',
  'constraints.phase_margin': 'phase margin',
  'window.start': 'start of the window',
  'window.end': 'end of the window',
};

/** Writes what the server has against a request: which number, why, and what is allowed. */
export function complaint({ loc, message, value, range, unit }: ProblemField): string {
  const got =
    typeof value === 'number'
      ? ` ${digits(value, 4)}`
      : typeof value === 'string' && value !== ''
        ? ` ${value}`
        : '';
  const shown = prettyUnit(unit ?? '');
  const allowed = range ? ` Allowed: ${range}${/\d/.test(range) ? ` ${shown}` : ''}` : '';
  return `${NAMES[loc] ?? loc}${got}: ${message}.${allowed.trimEnd()}${allowed ? '.' : ''}`;
}

/** A gain margin as a person of the field writes it, and back. */
export const decibels = (factor: number): number => clean(20 * Math.log10(factor));
export const factorOf = (dB: number): number => clean(10 ** (dB / 20));
