/** The form of an identification, and its request. */

import type { RequestOf } from '../../app/api/operations';
import { at, without } from '../../app/api/scenario-paths';
import type { Axis, Changes, FieldEntry, ProblemField, Scenario, Value } from '../../app/api/types';
import { permitted, shownIn } from '../../app/fields/fields.svelte';
import type { ScenarioSource } from '../../app/jobs/job-request';
import { load, oneOf, save } from '../../app/storage';
import { nested, ScenarioForm } from '../../study/study-form.svelte';
import { parseNumber, quantity } from '../../ui/units';

export type Body = RequestOf<'/identify'> & ScenarioSource & { speeds: number[] };

/** The speeds of the motions; the form has them in place of the list. */
export interface Range {
  /** m/s */
  slowest: number;
  fastest: number;
  count: number;
  spacing: 'log' | 'linear';
}

const choice = (value: string, description: string) => {
  return { value, label: value, description, unit: '' };
};
const PLAIN = { label: '', unit: '', factor: 1, whole: false, description: '' };
/** Fields that only the form has. */
const OWN: Readonly<Record<string, Partial<FieldEntry>>> = {
  'range.slowest': { label: 'slowest', default: 0 },
  'range.fastest': { label: 'fastest', default: 0 },
  'range.count': { ...PLAIN, label: 'speeds', whole: true, default: 0 },
  'range.spacing': {
    ...PLAIN,
    label: 'spacing',
    choices: [
      choice('log', 'Each as far from the next in ratio'),
      choice('linear', 'Each as far from the next in mm/s'),
    ],
  },
  motor: { ...PLAIN, label: 'motor' },
};

export class ExperimentForm extends ScenarioForm {
  /** Whether a kept run is read; else motions are carried out. */
  byRun = $state(load<string>('identify.by', 'experiment', oneOf('experiment', 'run')) === 'run');

  readonly axes = $derived.by((): Axis[] => {
    const axis = this.text('axis');
    return axis === 'x' || axis === 'y' ? [axis] : ['x', 'y'];
  });

  readonly range = $derived.by((): Range => {
    const number = (name: string) => this.number(`range.${name}`) ?? 0;
    return {
      slowest: number('slowest'),
      fastest: number('fastest'),
      count: number('count'),
      spacing: this.text('range.spacing') === 'linear' ? 'linear' : 'log',
    };
  });

  /** The request; null before there is a scenario, and a run where one is read. */
  readonly request = $derived.by((): Body | null => {
    if (!this.question || (this.byRun && this.text('run') === '')) return null;
    const motor = this.text('motor');
    const set = withoutMotion(this.question.set, motor);
    return {
      scenario: this.question.scenario,
      set: motor === '' ? set : { ...set, plant: motor },
      ...this.body(),
    } as Body;
  });

  readBy(way: 'experiment' | 'run'): void {
    this.byRun = way === 'run';
    save('identify.by', way);
  }

  override body(): Record<string, unknown> {
    const own = Object.entries(this.entered).filter(
      ([path, value]) =>
        !(path in OWN) && (this.byRun ? value !== '' : !/^(run|record)(\.|$)/.test(path)),
    );
    return {
      ...nested(Object.fromEntries(own)),
      speeds: speedsOf(this.range),
      variant: this.text('variant') || null,
      apply_to: this.text('apply_to') || null,
    };
  }

  override restore(request: Record<string, unknown>): void {
    super.restore(request);
    this.readBy(typeof request['run'] === 'string' ? 'run' : 'experiment');
    const { speeds, set } = request as Partial<Body>;
    const motor = set?.['plant'];
    this.put({
      ...without(this.entered, ['speeds']),
      ...(speeds && speeds.length > 1 ? below(rangeOf(speeds)) : {}),
      ...(typeof motor === 'string' ? { motor } : {}),
    });
  }

  override alias(path: string): string {
    return path.startsWith('range.') ? 'speeds' : path;
  }

  override entry(path: string): FieldEntry | undefined {
    const entry = super.entry(path);
    return path in OWN ? { ...PLAIN, ...entry, ...OWN[path] } : entry;
  }

  override label(path: string): string {
    return path === 'variant' && this.byRun ? 'force map of' : super.label(path);
  }

  protected override usual(path: string): Value {
    if (path === 'motor') return '';
    if (!(path in OWN)) return super.usual(path);
    const speeds = super.usual('speeds');
    return Array.isArray(speeds) ? (below(rangeOf(speeds as number[]))[path] ?? null) : null;
  }

  protected override lasts(path: string): boolean {
    return /^(run|record)(\.|$)/.test(path);
  }

  protected override placeOf(problem: ProblemField): string {
    return /^speeds(\.|$)/.test(problem.loc) ? 'range.count' : super.placeOf(problem);
  }

  protected override refusal(problem: ProblemField): string {
    const [, index] = /^speeds\.(\d+)$/.exec(problem.loc) ?? [];
    if (index === undefined) return super.refusal(problem);
    const { number, unit } = quantity(this.request?.speeds[Number(index)], 'm/s');
    const allowed = permitted(problem, shownIn(problem, this.field('range.slowest')));
    return `${number} ${unit} ${problem.message}.${allowed}`;
  }
}

const below = (range: Range): Changes =>
  Object.fromEntries(Object.entries(range).map(([name, value]) => [`range.${name}`, value]));

/** Returns the speeds, m/s, rounded to readable numbers. */
export function speedsOf({ slowest, fastest, count, spacing }: Range): number[] {
  const last = Math.max(1, Math.round(count) - 1);
  return Array.from({ length: last + 1 }, (_, k) => {
    const share = k / last;
    const speed =
      spacing === 'log'
        ? slowest * (fastest / slowest) ** share
        : slowest + (fastest - slowest) * share;
    return Number(speed.toPrecision(4));
  });
}

/** Returns which speeds a list has; one that is spaced in neither way is shown as the closer one. */
export function rangeOf(speeds: readonly number[]): Range {
  const range = {
    slowest: Math.min(...speeds),
    fastest: Math.max(...speeds),
    count: speeds.length,
  };
  const linear = speedsOf({ ...range, spacing: 'linear' });
  return { ...range, spacing: linear.every((speed, i) => speed === speeds[i]) ? 'linear' : 'log' };
}

/** Returns the changes that an identification heeds: it has a motion of its own. */
export function withoutMotion(changes: Changes, motor: string): Changes {
  const kept = Object.entries(changes).filter(
    ([path]) =>
      !/^(trajectory|schedule|window)(\.|$)/.test(path) &&
      !(motor !== '' && /^plant(\.|$)/.test(path)),
  );
  return Object.fromEntries(kept);
}

/** Reads rates that were typed, "20 50 100" or "20; 50"; null when one of them is no number. */
export function ratesOf(text: string): number[] | null {
  const rates = text
    .split(/[\s;]+/)
    .filter((part) => part !== '')
    .map(parseNumber);
  return rates.length > 0 && rates.every((rate) => rate !== null) ? rates : null;
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
