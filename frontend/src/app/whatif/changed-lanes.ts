/** Lane parameters of a changed scenario, made in the page as the server makes them. */

import type * as code from '../../../lanes.js';
import type { Lanes } from '../../kernel/lanes';
import { AXES, LANES } from '../../kernel/module';
import { at, difference, equal, type ScenarioDifference, withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Value } from '../api/types';
import { entryOf } from '../fields/fields.svelte';
import { refuse } from './refused-changes';

/** The module that `motionlab.targets.lane_code` generates. */
export type LaneCode = typeof code;

/** A change that takes more than the page has: inputs, tables of a map, code of another version. */
export class Beyond extends Error {}

/** Fields that decide the inputs of a run, or what only the server computes. */
const INPUTS =
  /^(trajectory|load|seed|schedule|window|learnt|plant\.[xy]\.(effects|encoder\.(noise|jitter)|amplifiers\.(noise|ripple_\w+)))(\.|$)/;
/** Fields whose numbers are read off the table of a force map, if it is one; what precedes is its owner. */
const OF_MAP = /^(plant\.[xy]|variants\.[A-Z]\.controller)\.(.*force_map|sharing)(\.|$)/;
/** Fields that notes are about; so is the law. */
const NOTED = /^plant\.[xy]\.encoder\./;
/** Relative difference of a number here and there: two libraries of elementary functions. */
const ROUNDING = 1e-9;

/**
 * Returns the lanes of a scenario from those that the server made of it before a change.
 *
 * Numbers that the change leaves alone stay the server's, to the last bit.
 *
 * @throws Refused, Beyond
 */
export function changedLanes(
  code: LaneCode,
  lanes: Lanes,
  before: Scenario,
  changed: Scenario,
): Lanes {
  if (code.MODEL !== lanes.result.model) throw new Beyond('the server has another version');
  const changes = differences(before, changed);
  checkReach(before, changed, changes);
  for (const law of lawsOf(changed)) {
    if (!Object.hasOwn(code.LAWS, law)) throw new Beyond(`the law ${law} is not known here`);
  }
  refuse(code, changed, changes);
  const numbers = withRows(code, lanes, before, changed);
  const variants = Object.keys(changed.variants).length;
  return {
    ...lanes,
    lanes: numbers,
    windows: windowsOf(lanes, changed, changes),
    tabled: lanes.tabled.map((_, i) =>
      readsTables(code, numbers, lanes.epochs.length, variants, i),
    ),
  };
}

function differences(before: Scenario, changed: Scenario): ScenarioDifference[] {
  // Of another motor each of its numbers, not its name.
  const unnamed = (each: Scenario) => ({ ...each, plant: { ...each.plant, name: '' } });
  return difference(unnamed(before), unnamed(changed));
}

/** Throws Beyond where a change decides more than numbers of lanes that are here. */
function checkReach(
  before: Scenario,
  changed: Scenario,
  changes: readonly ScenarioDifference[],
): void {
  if (!equal(Object.keys(before.variants), Object.keys(changed.variants))) {
    throw new Beyond('the scenario has other variants');
  }
  for (const { path, from, to } of changes) {
    if (INPUTS.test(path)) throw new Beyond(`${path} decides the inputs of the run`);
    const owner = OF_MAP.exec(path)?.[1];
    if (owner && [before, changed].some((each) => hasTable(each, owner))) {
      throw new Beyond(`${path} decides what is read off the table of a force map`);
    }
    if (!isOfKind(path, from, to)) throw new Beyond(`${path} is not known here`);
  }
  const { law, planned_for } = changed.trajectory as { law?: string; planned_for?: unknown };
  if (changes.length > 0 && law === 'time_optimal' && !planned_for) {
    throw new Beyond('the motion is planned for the motor');
  }
}

/** The laws that variants have at 0 s; what a schedule changes stays as the server made it. */
function lawsOf({ variants }: Scenario): string[] {
  return Object.values(variants).map(({ controller }) => controller.compensation.law);
}

function hasTable(scenario: Scenario, owner: string): boolean {
  const places = owner.startsWith('plant') ? [''] : AXES.map((axis) => `model.${axis}.`);
  return places.some((place) => at(scenario, `${owner}.${place}force_map.kind`) !== 'analytic');
}

/** Whether a value can be one of its field: the server says what is wrong with any other. */
function isOfKind(path: string, from: Value | undefined, to: Value | undefined): boolean {
  if (from === undefined || to === undefined) return false;
  if (typeof to === 'string') {
    return entryOf(path)?.choices?.some(({ value }) => value === to) === true;
  }
  return from === null || to === null || typeof from === typeof to;
}

/** The lane parameters, with those in place that a change decides. */
function withRows(
  { rows, PARAMETERS }: LaneCode,
  { lanes, epochs, period }: Lanes,
  before: Scenario,
  changed: Scenario,
): Float64Array {
  const names = Object.keys(changed.variants);
  const count = PARAMETERS.length;
  if (lanes.length !== epochs.length * names.length * count * LANES) {
    throw new Beyond('the server has other rows');
  }
  const numbers = lanes.slice();
  epochs.forEach((tick, epoch) => {
    const [old, now] = [inEffect(before, tick, period), inEffect(changed, tick, period)];
    names.forEach((name, i) => {
      AXES.forEach((axis, lane) => {
        const values = rows(now, name, axis);
        rows(old, name, axis).forEach((value, row) => {
          const place = ((epoch * names.length + i) * count + row) * LANES + lane;
          if (value !== undefined && !close(value, numbers[place] as number)) {
            throw new Beyond(`the server has another ${PARAMETERS[row]}`);
          }
          const next = values[row];
          if (next !== undefined && next !== value) numbers[place] = next;
        });
      });
    });
  });
  return numbers;
}

function close(a: number, b: number): boolean {
  return a === b || Math.abs(a - b) <= ROUNDING * Math.max(Math.abs(a), Math.abs(b));
}

/** What is said of each window, with notes left out that may no longer hold. */
function windowsOf(
  { windows, period }: Lanes,
  changed: Scenario,
  changes: readonly ScenarioDifference[],
): Lanes['windows'] {
  const encoder = changes.some(({ path }) => NOTED.test(path));
  return windows.map((window) => {
    const scenario = inEffect(changed, window.end - 1, period);
    const heads = Object.entries(window.variants).map(([name, head]) => {
      const { law, enabled } = at(scenario, `variants.${name}.controller.compensation`) as {
        law: string;
        enabled: boolean;
      };
      const notes = encoder || law !== head.law ? [] : head.notes;
      return [name, { ...head, law, enabled, notes }] as const;
    });
    const { settling_band } = changed;
    return { ...window, settling_band, variants: Object.fromEntries(heads) };
  });
}

/** The parameters that hold from a tick on. */
export function inEffect(scenario: Scenario, tick: number, period: number): Scenario {
  return scenario.schedule
    .filter(({ time }) => Math.round(time / period) <= tick)
    .reduce((before, { set }) => withChanges(before, set as Changes), scenario);
}

/** Whether a variant runs in the kernel with tables. */
function readsTables(
  { PARAMETERS, CLOSED_FORM }: LaneCode,
  numbers: Float64Array,
  epochs: number,
  variants: number,
  variant: number,
): boolean {
  const value = (epoch: number, path: string, lane: number) =>
    numbers[
      ((epoch * variants + variant) * PARAMETERS.length + PARAMETERS.indexOf(path)) * LANES + lane
    ] as number;
  const tabled = AXES.map((_, lane) =>
    Array.from({ length: epochs }, (_, epoch) => epoch).some(
      (epoch) =>
        value(epoch, 'force_map.table.thrust', lane) >= 0 ||
        value(epoch, 'force_model.map.table.thrust', lane) >= 0 ||
        value(epoch, 'force_model.sharing.law', lane) !== CLOSED_FORM,
    ),
  );
  if (tabled[0] !== tabled[1]) throw new Beyond('one axis alone reads a table');
  return tabled[0] as boolean;
}
