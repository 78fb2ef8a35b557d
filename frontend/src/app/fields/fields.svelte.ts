/** How each field is called and shown. The server says so, once; nothing here knows a field. */

import { clean, digits, minus, pretty, prettyUnit } from '../../ui/units';
import type { FieldEntry, ProblemField, Scenario, ScenarioFields, Value } from '../api/types';
import { at, isTable, LEARNT, without } from '../api/scenario-paths';
import { messages } from '../messages.svelte';

export type Entries = Readonly<Record<string, FieldEntry>>;

export interface Field {
  label: string;
  /** Unit on the screen. */
  unit: string;
  /** Displayed number = SI value times this. */
  factor: number;
  whole: boolean;
}

class Served {
  /** What is known of the fields of a scenario and of its metrics; empty until the server answers. */
  scenario = $state.raw<ScenarioFields>({ fields: {}, schedulable: [], metrics: {}, contour: {} });
  /** The same of requests of studies, by kind. */
  requests = $state.raw<Readonly<Record<string, Entries>>>({});
}

export const served = new Served();

/** The entry of a path: all variants share one, and so do the items of a list. */
export function entryOf(path: string, entries?: Entries): FieldEntry | undefined {
  const known = entries ?? served.scenario.fields;
  const key = path
    .replace(/^variants\.[A-Z](?=\.|$)/, 'variants.*')
    .replace(/\.\d+(?=\.|$)/g, '.*');
  return known[key] ?? known[key.replace(/\.\*$/, '')];
}

/** Returns how a path's value is shown. */
export function fieldOf(path: string, entries?: Entries): Field {
  const entry = entryOf(path, entries);
  const { unit, factor, whole } = entry ?? { unit: '', factor: 1, whole: false };
  const label = entry?.label ?? path.split('.').slice(-2).join(' ').replaceAll('_', ' ');
  return { label, unit: prettyUnit(unit), factor, whole };
}

/** Returns the values that a field can take; none where it is no choice. */
export function choicesOf(path: string, entries?: Entries) {
  return entryOf(path, entries)?.choices ?? [];
}

/** The same as options of `Segments`. */
export function optionsOf<T extends string>(path: string, entries?: Entries) {
  return choicesOf(path, entries).map(({ value, label, description }) => {
    return { value: value as T, name: label, title: description };
  });
}

/** Returns who a path belongs to: `B`, `plant x`, or nothing. */
export function ownerOf(path: string): string {
  const [, variant] = /^variants\.([A-Z])\./.exec(path) ?? [];
  if (variant !== undefined) return variant;
  const [, axis] = /^plant\.([xy])\./.exec(path) ?? [];
  return axis === undefined ? '' : `plant ${axis}`;
}

/** Returns what a change is called: `B k_p x`, `plant y stiction F_s`. */
export function nameOf(path: string, entries?: Entries): string {
  return `${ownerOf(path)} ${fieldOf(path, entries).label}`.trim();
}

/** Whether a change needs a run from the start: the path and the draws are decided at tick 0. */
export function needsRestart(path: string): boolean {
  return !served.scenario.schedulable.includes(path.split('.')[0] ?? '');
}

/** A learnt force by its laps; lists of runs have that in words already. */
function lapsText(value: Value | undefined): string {
  if (typeof value === 'string') return value;
  if (!isTable(value)) return 'none';
  return `${String(value['laps'])} ${value['laps'] === 1 ? 'lap' : 'laps'}`;
}

/** Writes a value for reading; `significant` digits. */
export function show(path: string, value: Value | undefined, significant = 4): string {
  if (path === LEARNT) return lapsText(value);
  if (value === undefined || value === null) return 'auto';
  if (typeof value === 'boolean') return value ? 'on' : 'off';
  if (typeof value === 'string')
    return choicesOf(path).find((choice) => choice.value === value)?.label ?? value;
  if (typeof value === 'number') {
    const { factor, whole } = fieldOf(path);
    return whole ? String(value) : trim(digits(clean(value * factor), significant));
  }
  if (Array.isArray(value)) return value.map((item) => show(path, item)).join(', ');
  return 'changed';
}

/** Writes what is wrong with a field: its value and range in the unit of the screen. */
export function refusal(problem: ProblemField, entries?: Entries): string {
  return refusalText(problem, fieldOf(problem.loc, entries));
}

type Scale = Pick<Field, 'factor' | 'unit'>;

/** The same in a unit that is given. */
export function refusalText(problem: ProblemField, scale: Scale): string {
  const { message, value } = problem;
  const shown = shownIn(problem, scale);
  // A sentence that begins with a symbol keeps it as it is.
  const first = /^\S+ = /.test(message) ? message.charAt(0) : message.charAt(0).toUpperCase();
  const words = (first + pretty(message).slice(1)).replace(/\.$/, '');
  const got = typeof value === 'number' ? `: ${shown.number(value)} ${shown.unit}`.trimEnd() : '';
  return `${words}${got}.${permitted(problem, shown)}`;
}

/** How numbers of a problem are shown: as the field; a count of its items as it is. */
export function shownIn({ unit }: ProblemField, field: Scale) {
  const scale = unit === 'items' ? { factor: 1, unit } : field;
  return {
    unit: scale.unit || prettyUnit(unit ?? ''),
    number: (value: number) => trim(digits(clean(value * scale.factor), 6)),
  };
}

/** Writes what is allowed instead; empty where the server does not say. */
export function permitted(
  { range, bounds, unit: siUnit }: ProblemField,
  { number, unit }: ReturnType<typeof shownIn>,
): string {
  const ends = boundsText(bounds ?? {}, number);
  const text =
    ends === '' ? `${range ?? ''} ${siUnit === 'items' ? siUnit : ''}` : `${ends} ${unit}`;
  return text.trim() === '' ? '' : ` Allowed: ${text.trim()}.`;
}

function boundsText(bounds: Readonly<Record<string, number>>, shown: (value: number) => string) {
  const { minimum, maximum, exclusive_minimum: above, exclusive_maximum: below } = bounds;
  if (minimum !== undefined && maximum !== undefined)
    return `${shown(minimum)} to ${shown(maximum)}`;
  const ends = [
    ['≥', minimum],
    ['>', above],
    ['≤', maximum],
    ['<', below],
  ] as const;
  return ends
    .flatMap(([sign, end]) => (end === undefined ? [] : [`${sign} ${shown(end)}`]))
    .join(' and ');
}

/** Writes a value into a field: no more digits than it has, and an ASCII minus. */
export function editable(path: string, value: number): string {
  const { factor, whole } = fieldOf(path);
  if (!Number.isFinite(value)) return '';
  return whole ? String(value) : String(Number(clean(value * factor).toPrecision(4)));
}

function trim(text: string): string {
  return minus(text.includes('.') && !text.includes('e') ? text.replace(/\.?0+$/, '') : text);
}

export function lawName(scenario: Scenario | null, variant: string): string {
  const compensation = `variants.${variant}.controller.compensation`;
  const law = at(scenario, `${compensation}.law`);
  if (typeof law !== 'string') return '';
  const name = show(`${compensation}.law`, law);
  const off = law !== 'off' && at(scenario, `${compensation}.enabled`) === false;
  return off ? `${name}, switched off` : name;
}

/** Paths of the parameters that a variant's law, or its sharing function, uses. */
export function lawParameters(
  scenario: Scenario | null,
  variant: string,
  part: 'compensation' | 'sharing' = 'compensation',
): string[] {
  const law = String(at(scenario, `variants.${variant}.controller.${part}.law`) ?? '');
  return Object.keys(served.scenario.fields)
    .filter((path) => path.startsWith(`variants.*.controller.${part}.`))
    .map((path) => path.replace('*', variant))
    .filter((path) => entryOf(path)?.used_with?.includes(law));
}

export class Refusals {
  /** Messages of values that the server refused. */
  problems = $state.raw<Record<string, string>>({});
  /** What stands in fields and is no number; empty while it is typed. */
  mistyped = $state.raw<Record<string, string>>({});

  /** Takes what the server says of fields; what names none becomes a message. */
  take(fields: readonly ProblemField[], detail: string): void {
    this.problems = Object.fromEntries(fields.map((field) => [field.loc, refusal(field)]));
    if (fields.length === 0 && detail !== '') messages.error(detail);
  }

  /** Forgets what was said of values that are being replaced, or of all. */
  clear(paths?: readonly string[]): void {
    this.problems = paths ? without(this.problems, paths) : {};
  }

  /** Takes what stands in a field in place of its value; null when it is gone. */
  mistype(path: string, text: string | null): void {
    const others = without(this.mistyped, [path]);
    this.mistyped = text === null ? others : { ...others, [path]: text };
  }
}
