/** Dotted paths into scenarios, and the difference between two scenarios. */

import type { Changes, Scenario, SessionInfo, Value } from './types';

type Table = { [key: string]: Value };

/** A force that was learnt of the motion; null without one. */
export const LEARNT = 'learnt';

export function isTable(value: unknown): value is Table {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/** Returns what a path leads to, or undefined. */
export function at(scenario: object | null, path: string): Value | undefined {
  let here: unknown = scenario;
  for (const key of path.split('.')) {
    if (!isTable(here)) return undefined;
    here = here[key];
  }
  return here as Value | undefined;
}

/** Returns the number that a path leads to, or NaN. */
export function numberAt(scenario: object | null, path: string): number {
  const value = at(scenario, path);
  return typeof value === 'number' ? value : Number.NaN;
}

/** Returns a copy with one value replaced; what is not on the way is shared with the original. */
export function withValue<T extends object>(scenario: T, path: string, value: Value): T {
  const [key = '', ...rest] = path.split('.');
  const inner = (scenario as Table)[key];
  const next =
    rest.length === 0 ? value : withValue(isTable(inner) ? inner : {}, rest.join('.'), value);
  return { ...scenario, [key]: next };
}

/**
 * Returns the scenario with changes applied. A part given by name is looked up in `parts` as
 * `path=name`; unknown ones are left as they were.
 */
export function withChanges(
  scenario: Scenario,
  changes: Changes,
  parts: Readonly<Record<string, Value>> = {},
): Scenario {
  let result = scenario;
  // Parts before what lies inside them, as the server does.
  for (const path of Object.keys(changes).sort()) {
    let value = changes[path] as Value;
    if (typeof value === 'string' && isTable(at(result, path))) {
      const part = parts[`${path}=${value}`];
      if (part === undefined) continue;
      value = part;
    }
    result = withValue(result, path, value);
  }
  return result;
}

export function equal(a: unknown, b: unknown): boolean {
  if (a === b) return true;
  if (Array.isArray(a) && Array.isArray(b)) {
    return a.length === b.length && a.every((item, i) => equal(item, b[i]));
  }
  if (isTable(a) && isTable(b)) {
    const keys = Object.keys(a);
    return keys.length === Object.keys(b).length && keys.every((key) => equal(a[key], b[key]));
  }
  return false;
}

export interface ScenarioDifference {
  path: string;
  from: Value | undefined;
  to: Value | undefined;
}

/** Texts that describe a scenario but do not change a run. */
const WORDS = new Set(['title', 'description', 'label']);

/**
 * Lists the values in which two scenarios differ, in the order of the second.
 *
 * A part that goes by another name, such as another motor, is one difference, not its hundred values.
 */
export function difference(from: object, to: object): ScenarioDifference[] {
  const differences: ScenarioDifference[] = [];
  walk(from as Table, to as Table, '', differences);
  return differences;
}

function walk(from: Table, to: Table, prefix: string, differences: ScenarioDifference[]): void {
  for (const key of new Set([...Object.keys(to), ...Object.keys(from)])) {
    if (WORDS.has(key)) continue;
    const path = prefix === '' ? key : `${prefix}.${key}`;
    const [a, b] = [from[key], to[key]];
    if (equal(a, b)) continue;
    if (isTable(a) && isTable(b) && path !== LEARNT) {
      if (isPart(path) && a.name !== b.name && b.name !== 'custom') {
        differences.push({ path, from: a.name, to: b.name });
      } else if (path === 'trajectory' && a.kind !== b.kind) {
        differences.push({ path, from: a.kind, to: b.kind });
      } else if (path.endsWith('.force_map') && (a.kind !== b.kind || a.name !== b.name)) {
        // One is a formula or another table: their numbers are not compared.
        differences.push({ path, from: a.name ?? a.kind, to: b.name ?? b.kind });
      } else {
        walk(a, b, path, differences);
      }
    } else if (key !== 'name' || prefix === '') {
      differences.push({ path, from: a, to: b });
    }
  }
}

function isPart(path: string): boolean {
  return path === 'plant' || path.endsWith('.controller');
}

/** Whether one of the paths is that of a value, or of a part that it lies in. */
function covers(paths: readonly string[], path: string): boolean {
  return paths.some((each) => path === each || path.startsWith(`${each}.`));
}

/**
 * Returns a session's scenario as it holds at 0 s: without what the schedule has changed since, but
 * with the user's changes.
 */
export function atStart({
  base,
  scenario,
  changes,
}: Pick<SessionInfo, 'base' | 'scenario' | 'changes'>): Scenario {
  const scheduled = scenario.schedule?.flatMap(({ set }) => Object.keys(set)) ?? [];
  if (scheduled.length === 0) return scenario;
  const overridden = changes.flatMap(({ set }) => Object.keys(set));
  const back = difference(base, scenario).filter(
    ({ path, from }) => from !== undefined && covers(scheduled, path) && !covers(overridden, path),
  );
  return back.reduce((result, { path, from }) => withValue(result, path, from as Value), scenario);
}

/** Returns those changes that have the form of what they replace: a link may hold anything. */
export function fitting(changes: Changes, scenario: Scenario): Changes {
  return Object.fromEntries(
    Object.entries(changes).filter(([path, value]) => {
      // Parts of a controller, such as a notch, are switched off by null; so is what was learnt.
      if (value === null)
        return path === LEARNT || path.includes('.controller.') || !isWhole(at(scenario, path));
      return fits(value, at(scenario, path));
    }),
  );
}

const isText = (value: Value) => typeof value === 'string';
const isWhole = (value: Value | undefined) => isTable(value) || Array.isArray(value);

function fits(value: Value, now: Value | undefined): boolean {
  if (now === undefined || now === null) return true;
  if (Array.isArray(now)) return Array.isArray(value);
  if (!isTable(now)) return !isWhole(value) && isText(value) === isText(now);
  return (
    isTable(value) &&
    Object.entries(value).every(([key, part]) => !(key in now) || fits(part, now[key]))
  );
}

export function ofTrajectory(path: string): boolean {
  return path.split('.')[0] === 'trajectory';
}

/** Returns a table by path without some paths. */
export function without<T>(
  table: Readonly<Record<string, T>>,
  paths: readonly string[],
): Record<string, T> {
  return Object.fromEntries(Object.entries(table).filter(([path]) => !paths.includes(path)));
}

/** Returns the paths in which two sets of changes differ. */
export function changedPaths(before: Changes, now: Changes): string[] {
  return Object.keys({ ...before, ...now }).filter((path) => !equal(before[path], now[path]));
}
