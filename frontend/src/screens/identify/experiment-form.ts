/** The form of an identification, and its request. */

import { at } from '../../app/api/scenario-paths';
import type { Axis, Changes, ProblemField, Scenario } from '../../app/api/types';
import { fieldOf, permitted, served, shownIn, type Entries } from '../../app/fields/fields.svelte';
import { listOf, nullOr, oneOf, partOf } from '../../app/storage';
import { parseNumber, quantity } from '../../ui/units';

export type Spacing = 'log' | 'linear';

export interface ExperimentForm {
  /** By motions of its own, or from a kept run. */
  by: 'experiment' | 'run';
  /** The run; empty: none chosen yet. */
  run: string;
  /** Of the run; empty: its first. */
  runVariant: string;
  /** Columns of the run; empty: those that the server finds. */
  position: string;
  force: string;
  /** Moving mass, kg; null: identified too. */
  mass: number | null;
  /** Of the filter, Hz; null: the server's choice. */
  bandwidth: number | null;
  /** Name of a shipped scenario; empty: what the Lab's controls show. */
  source: string;
  /** Name of a shipped motor; empty: the scenario's own. */
  motor: string;
  axis: Axis | 'both';
  /** Whose gains and force map drive the motor; empty: the first. */
  variant: string;
  /** Whose model is identified; empty: the second, or the only one. */
  applyTo: string;
  /** Slowest and fastest motion, m/s. */
  slowest: number;
  fastest: number;
  speeds: number;
  spacing: Spacing;
  /** Time after which a motion takes no further pole pitch, s. */
  timeMax: number;
  /** Most pole pitches of a motion; null: as many as fit. */
  pitchesMax: number | null;
  ramps: boolean;
  /** N/s */
  rates: readonly number[];
  share: number;
  places: number;
}

/** The form of the settings that a browser keeps. */
export const KEPT = partOf({
  by: oneOf('experiment', 'run'),
  run: '',
  runVariant: '',
  position: '',
  force: '',
  mass: nullOr(0),
  bandwidth: nullOr(0),
  source: '',
  motor: '',
  axis: oneOf('x', 'y', 'both'),
  variant: '',
  applyTo: '',
  slowest: 0,
  fastest: 0,
  speeds: 0,
  spacing: oneOf('log', 'linear'),
  timeMax: 0,
  pitchesMax: nullOr(0),
  ramps: true,
  rates: listOf(0),
  share: 0,
  places: 0,
});

/** Fields of the request, which are there before the screen is. */
export function fields(): Entries {
  return served.requests.identify ?? {};
}

const NO_RUN = {
  by: 'experiment',
  run: '',
  runVariant: '',
  position: '',
  force: '',
  mass: null,
  bandwidth: null,
} as const;

/** What the server takes for what is left out. */
export function defaults(): ExperimentForm {
  const request = Object.entries(fields()).map(([path, entry]) => [path, entry.default]);
  const form = formOf(Object.fromEntries(request) as Record<string, unknown>);
  const none = { source: '', variant: '', applyTo: '', pitchesMax: null };
  return { ...none, ...NO_RUN, ...form } as ExperimentForm;
}

/** Places in a pole pitch; at six all would see the same part of a ripple of a sixth of it. */
export const PLACES: readonly number[] = [4, 5, 7, 9, 11, 13, 25];

/** What is read of a run; what is left out is found by the server. */
export interface RecordBody {
  variant?: string;
  position?: string;
  force?: string;
  mass?: number;
  bandwidth?: number;
}

export interface Body {
  run?: string;
  record?: RecordBody;
  scenario: Scenario;
  set: Changes;
  axis: ExperimentForm['axis'];
  speeds: number[];
  time_max: number;
  pitches_max: number | null;
  presliding: { enabled: boolean; rates: readonly number[]; share: number; places: number };
  variant: string | null;
  apply_to: string | null;
}

type Speeds = Pick<ExperimentForm, 'slowest' | 'fastest' | 'speeds' | 'spacing'>;

/** Returns the speeds, m/s, rounded to readable numbers. */
export function speedsOf({ slowest, fastest, speeds, spacing }: Speeds): number[] {
  const last = Math.max(1, Math.round(speeds) - 1);
  return Array.from({ length: last + 1 }, (_, k) => {
    const share = k / last;
    const speed =
      spacing === 'log'
        ? slowest * (fastest / slowest) ** share
        : slowest + (fastest - slowest) * share;
    return Number(speed.toPrecision(4));
  });
}

/** Returns the changes that an identification heeds: it has a motion of its own. */
function withoutMotion(changes: Changes, motor: string): Changes {
  const kept = Object.entries(changes).filter(
    ([path]) =>
      !/^(trajectory|schedule|window)(\.|$)/.test(path) &&
      !(motor !== '' && /^plant(\.|$)/.test(path)),
  );
  return Object.fromEntries(kept);
}

export function bodyOf(form: ExperimentForm, scenario: Scenario, changes: Changes): Body {
  const { axis, timeMax, pitchesMax, ramps, rates, share, places, variant, applyTo, motor } = form;
  const has = (name: string) => (name in scenario.variants ? name : null);
  return {
    ...(form.by === 'run' ? { run: form.run, record: recordOf(form) } : {}),
    scenario,
    set: { ...withoutMotion(changes, motor), ...(motor === '' ? {} : { plant: motor }) },
    axis,
    speeds: speedsOf(form),
    time_max: timeMax,
    pitches_max: pitchesMax,
    presliding: { enabled: ramps, rates, share, places },
    variant: has(variant),
    apply_to: has(applyTo),
  };
}

function recordOf(form: ExperimentForm): RecordBody {
  const { runVariant, position, force, mass, bandwidth } = form;
  return {
    ...(runVariant === '' ? {} : { variant: runVariant }),
    ...(position === '' ? {} : { position }),
    ...(force === '' ? {} : { force }),
    ...(mass === null ? {} : { mass }),
    ...(bandwidth === null ? {} : { bandwidth }),
  };
}

const KEYS = [
  'run',
  'record',
  'axis',
  'speeds',
  'time_max',
  'pitches_max',
  'presliding',
  'variant',
  'apply_to',
];

/** Names of the settings of an experiment, by their key in a request. */
export function settings(): Record<string, string> {
  return Object.fromEntries(KEYS.map((key) => [key, fieldOf(key, fields()).label]));
}

/** Returns the form of an experiment's request, without its scenario. */
export function formOf(request: Readonly<Record<string, unknown>>): Partial<ExperimentForm> {
  const asked = request as Partial<Body>;
  const { speeds, presliding, set, run, record = {} } = asked;
  const motor = set?.['plant'];
  const form: { [Key in keyof ExperimentForm]?: ExperimentForm[Key] | undefined } = {
    by: run ? 'run' : 'experiment',
    ...(run ? formOfRecord(run, record) : {}),
    motor: typeof motor === 'string' ? motor : '',
    axis: asked.axis,
    variant: asked.variant === undefined ? undefined : (asked.variant ?? ''),
    applyTo: asked.apply_to === undefined ? undefined : (asked.apply_to ?? ''),
    ...(speeds && speeds.length > 1 ? spacingOf(speeds) : {}),
    timeMax: asked.time_max,
    pitchesMax: asked.pitches_max,
    ramps: presliding?.enabled,
    rates: presliding?.rates,
    share: presliding?.share,
    places: presliding?.places,
  };
  const said = Object.entries(form).filter(([, value]) => value !== undefined);
  return Object.fromEntries(said) as Partial<ExperimentForm>;
}

function formOfRecord(run: string, record: RecordBody): Partial<ExperimentForm> {
  const { variant = '', position = '', force = '', mass = null, bandwidth = null } = record;
  return { run, runVariant: variant, position, force, mass, bandwidth };
}

/** Returns which speeds a list has; one that is spaced in neither way is shown as the closer one. */
function spacingOf(list: readonly number[]): Speeds {
  const [slowest, fastest] = [Math.min(...list), Math.max(...list)];
  const form = (spacing: Spacing) => ({ slowest, fastest, speeds: list.length, spacing });
  const linear = speedsOf(form('linear'));
  return form(linear.every((speed, i) => speed === list[i]) ? 'linear' : 'log');
}

/** Reads rates that were typed, "20 50 100" or "20; 50"; null when one of them is no number. */
export function ratesOf(text: string): number[] | null {
  const rates = text
    .split(/[\s;]+/)
    .filter((part) => part !== '')
    .map(parseNumber);
  return rates.length > 0 && rates.every((rate) => rate !== null) ? rates : null;
}

/** Writes what the server has against a request: which number, why, and what is allowed. */
export function complaint(problem: ProblemField, { speeds }: Pick<Body, 'speeds'>): string {
  const { loc, message, value } = problem;
  const shown = shownIn(problem, fieldOf(loc, fields()));
  const allowed = permitted(problem, shown);
  const [, index] = /^speeds\.(\d+)$/.exec(loc) ?? [];
  if (index !== undefined) {
    const { number, unit } = quantity(speeds[Number(index)], 'm/s');
    return `${number} ${unit} ${message}.${allowed}`;
  }
  const got = typeof value === 'number' ? ` ${shown.number(value)}` : '';
  return `${fieldOf(loc, fields()).label}${got}: ${message}.${allowed}`;
}

/** Writes the server's errors of a request; the same error of many speeds once. */
export function complaints(
  problems: readonly ProblemField[],
  body: Pick<Body, 'speeds'>,
): readonly string[] {
  return [...new Set(problems.map((problem) => complaint(problem, body)))];
}

/** Whether a variant has a law that makes use of the model. */
export function compensates(scenario: Scenario, set: Changes, variant: string): boolean {
  const path = `variants.${variant}.controller.compensation.law`;
  return (set[path] ?? at(scenario, path)) !== 'off';
}

/** Returns changes that also switch the compensation on, as a schedule may do later. */
export function compensated(scenario: Scenario, set: Changes, variant: string): Changes {
  if (!compensates(scenario, set, variant)) return set;
  return { ...set, [`variants.${variant}.controller.compensation.enabled`]: true };
}
