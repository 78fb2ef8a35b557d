/** The form of a sweep: its fields, its request, and errors of the server. */

import { at, LEARNT, without } from '../../app/api/scenario-paths';
import type { ProblemField, Scenario, Value } from '../../app/api/types';
import { choicesOf, fieldOf, ownerOf, refusal, show } from '../../app/fields/fields.svelte';
import { listOf, oneOf } from '../../app/storage';
import { clean, parseNumber } from '../../ui/units';

/** One swept field; numbers as they are typed, in the unit of the screen. */
export interface SweptField {
  path: string;
  /** Values one by one, or ends, number and spacing of a range. */
  by: 'range' | 'values';
  values: string;
  start: string;
  stop: string;
  count: string;
  scale: 'linear' | 'log';
}

/** A text input of a swept field. */
export type Input = 'start' | 'stop' | 'count' | 'values';

/** What is refused of a swept field: which input, or the SI value that one of them holds. */
export interface Problem {
  key?: Input | undefined;
  value?: number;
  text: string;
}
export type Problems = Readonly<Record<number, readonly Problem[]>>;

/** The swept fields that a browser keeps. */
export const KEPT = listOf({
  path: '',
  by: oneOf('range', 'values'),
  values: '',
  start: '',
  stop: '',
  count: '',
  scale: oneOf('linear', 'log'),
});

export const FIELDS_MAX = 6;
export const OBJECTIVES_MAX = 4;
export const LIMITS_MAX = 8;

/** What a case has to meet; the number as it is typed, in the unit of the screen. */
export interface LimitEntry {
  of: string;
  by: 'at_least' | 'at_most';
  value: string;
}

export const KEPT_LIMITS = listOf({ of: '', by: oneOf('at_least', 'at_most'), value: '' });

/** Ways to combine the values of all fields. */
export const COMBINATIONS = [
  { value: 'grid', name: 'every combination' },
  { value: 'list', name: 'first with first' },
  { value: 'random', name: 'drawn: random' },
  { value: 'latin-hypercube', name: 'drawn: Latin hypercube' },
  { value: 'sobol', name: 'drawn: Sobol' },
  { value: 'search', name: 'searched' },
] as const;

/** Whether the number of cases is chosen, and not that of the values. */
export function isDrawn(combine: string): boolean {
  return combine !== 'grid' && combine !== 'list';
}
const WORDS = new Set(['title', 'description', 'label', 'name', 'source']);

/** A field swept around its value in a scenario: from half to double, or all values that it can take. */
export function sweptOf(
  path: string,
  scenario: Scenario | null,
  motors: readonly string[],
): SweptField {
  const value = at(scenario, path);
  const { factor, whole } = fieldOf(path);
  const shown = (number: number, digits = 2) =>
    String(Number(clean(number * factor).toPrecision(digits)));
  const ranged = typeof value === 'number';
  const rough = (number: number) => (whole ? Math.round(number) : number);
  const [start, stop] = ranged && value !== 0 ? [rough(value / 2), rough(value * 2)] : [0, 1];
  return {
    path,
    by: ranged && whole !== true ? 'range' : 'values',
    values:
      path === 'plant'
        ? motors.join(', ')
        : typeof value === 'boolean'
          ? 'off, on'
          : ranged
            ? [shown(start), shown(value, 6), shown(stop)].join(', ')
            : choicesOf(path)
                .map((choice) => choice.value)
                .join(', '),
    start: shown(start),
    stop: shown(stop),
    count: '9',
    scale: ranged && start > 0 ? 'log' : 'linear',
  };
}

export interface FieldGroup {
  name: string;
  fields: readonly { path: string; name: string }[];
}

/** Lists the numbers, switches and choices of a scenario by what they belong to, and the motor as a whole. */
export function groupsOf(scenario: Scenario | null): readonly FieldGroup[] {
  const groups = new Map<string, { path: string; name: string }[]>();
  const walk = (value: unknown, path: string) => {
    const choice = typeof value === 'string' && choicesOf(path).length > 0;
    if (typeof value === 'number' || typeof value === 'boolean' || choice) {
      const group = groupOf(path);
      const { label, unit } = fieldOf(path);
      const [, letter] = /^variants\.([A-Z])\./.exec(path) ?? [];
      const of = letter === undefined ? '' : `${letter} `;
      const name = `${of}${label.replaceAll('_', '')}${unit && `, ${unit}`}`;
      groups.set(group, [...(groups.get(group) ?? []), { path, name }]);
    } else if (typeof value === 'object' && value !== null && !Array.isArray(value)) {
      for (const [key, inner] of Object.entries(value)) {
        if (!WORDS.has(key)) walk(inner, path === '' ? key : `${path}.${key}`);
      }
    }
  };
  const { variants, plant, trajectory, ...rest } = scenario ?? {};
  walk({ variants, plant, trajectory, ...without(rest, [LEARNT]) }, '');
  const named = [...groups].map(([name, fields]) => ({ name, fields }));
  return [{ name: 'motor', fields: [{ path: 'plant', name: 'which motor' }] }, ...named];
}

function groupOf(path: string): string {
  const [, model] = /^variants\.([A-Z])\.controller\.model\./.exec(path) ?? [];
  if (model !== undefined) return `model of ${model}`;
  const owner = ownerOf(path);
  if (owner !== '') return /^[A-Z]$/.test(owner) ? `controller ${owner}` : owner;
  const [first = ''] = path.split('.');
  return path.includes('.') ? first.replaceAll('_', ' ') : 'scenario';
}

/** The request; throws Refused if an entry is no number. */
export function gridOf(fields: readonly SweptField[], drawn = false): object[] {
  const problems: Record<number, Problem[]> = {};
  const grid = fields.map((swept, k) => {
    const { path, by, scale } = swept;
    const { factor } = fieldOf(path);
    const number = (key: 'start' | 'stop' | 'count', of: number) => {
      const text = swept[key];
      const value = parseNumber(text);
      if (value === null) {
        (problems[k] ??= []).push({ key, text: `“${text.trim()}” is not a number.` });
      }
      return clean((value ?? 0) / of);
    };
    if (by === 'range') {
      const [start, stop] = [number('start', factor), number('stop', factor)];
      return { path, start, stop, ...(drawn ? {} : { count: number('count', 1) }), scale };
    }
    return { path, values: split(swept.values).map((text) => valueOf(text, factor)) };
  });
  if (Object.keys(problems).length > 0) throw new Refused(problems);
  return grid;
}

export class Refused extends Error {
  constructor(readonly problems: Problems) {
    super('Not a number');
  }
}

/** Values apart: by spaces or semicolons, or by commas, which are no decimal commas before a space. */
function split(texts: string): string[] {
  return texts.split(/[\s;]+|,(?=\s|$)|,(?=[^\d])/).filter((text) => text !== '');
}

/** A value as it is typed: a number in the unit of the screen, on or off, or a name. */
function valueOf(text: string, factor: number): Value {
  const number = parseNumber(text);
  if (number !== null) return clean(number / factor);
  return text === 'on' ? true : text === 'off' ? false : text;
}

/** Returns the swept fields of the request of a job. */
export function sweptFields(request: Record<string, unknown>): SweptField[] {
  const grid = (request.grid ?? []) as Partial<Record<string, Value>>[];
  return grid.map(({ path: swept, values, start, stop, count, scale }) => {
    const path = String(swept);
    const { factor } = fieldOf(path);
    const text = (value: Value | undefined): string => {
      if (typeof value === 'number') return String(clean(value * factor));
      return typeof value === 'boolean' ? (value ? 'on' : 'off') : String(value ?? '');
    };
    return {
      path,
      by: Array.isArray(values) ? 'values' : 'range',
      values: Array.isArray(values) ? values.map(text).join(', ') : '',
      start: text(start),
      stop: text(stop),
      count: String(count ?? 9),
      scale: scale === 'log' ? 'log' : 'linear',
    };
  });
}

/** Puts what the server refuses beside the field that it is about; `null` is the whole request. */
export function refusedFields(errors: readonly ProblemField[]): {
  byField: Record<number, Problem[]>;
  others: string[];
} {
  const byField: Record<number, Problem[]> = {};
  const others: string[] = [];
  for (const error of errors) {
    const [, index, key] = /^grid\.(\d+)(?:\.(start|stop|count|values))?/.exec(error.loc) ?? [];
    // The field of the scenario that is refused is named before what is wrong with it.
    const [, path = '', message = error.message] =
      /^((?:\w+\.)*\w+): (.*)$/s.exec(error.message) ?? [];
    if (index === undefined) others.push(refusal(error));
    else {
      const text = refusal({ ...error, loc: path, message });
      const value = typeof error.value === 'number' ? { value: error.value } : {};
      (byField[Number(index)] ??= []).push({ key: key as Input | undefined, text, ...value });
    }
  }
  return { byField, others };
}

/** Whether an input holds what is refused; all of them where that is not known. */
export function isWrong(swept: SweptField, problems: readonly Problem[], key: Input): boolean {
  const { factor } = fieldOf(swept.path);
  const holds = (input: 'start' | 'stop', value: number) =>
    clean((parseNumber(swept[input]) ?? Number.NaN) / factor) === value;
  return problems.some(({ key: named, value }) => {
    if (named !== undefined) return named === key;
    const log = swept.by === 'range' && swept.scale === 'log';
    const ends = (['start', 'stop'] as const).filter((input) =>
      value === undefined
        ? log && (parseNumber(swept[input]) ?? 0) <= 0 // which has no logarithm
        : holds(input, value),
    );
    return ends.length === 0 || ends.some((input) => input === key);
  });
}

/** Number of cases that are listed; NaN while undefined. */
export function casesOf(combine: string, fields: readonly SweptField[]): number {
  const sizes = fields.map(({ by, values, count }) =>
    by === 'range' ? (parseNumber(count) ?? Number.NaN) : split(values).length,
  );
  return combine === 'list' ? (sizes[0] ?? 0) : sizes.reduce((all, size) => all * size, 1);
}

/** Writes the value of a swept field with its unit. */
export function valueText(path: string, value: Value): string {
  const { unit } = fieldOf(path);
  return `${show(path, value)} ${typeof value === 'number' ? unit : ''}`.trimEnd();
}
