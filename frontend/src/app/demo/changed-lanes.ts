/** Lane parameters of a changed scenario, made in the page as the server makes them. */

import type { Lanes } from '../../kernel/lanes';
import { AXES, LANES } from '../../kernel/module';
import { at, difference, equal, withChanges } from '../api/scenario-paths';
import type { Changes, ProblemField, Scenario, Value } from '../api/types';
import { entryOf } from '../fields/fields.svelte';

/** The module `lanes.js` of a demo, generated from the functions of the server. */
export interface LaneCode {
  PARAMETERS: readonly string[];
  STATES: readonly string[];
  LEAST_NORM: number;
  PLANT_STEP: number;
  /** Undefined where a table decides. */
  rows(scenario: Scenario, variant: string, axis: string): (number | undefined)[];
  refusal(compensation: object, model: object): Refusal | null;
}

interface Refusal {
  parameter: string;
  value: number;
  reason: string;
  limit: number;
}

/** A change that the server would refuse. */
export class Refused extends Error {
  constructor(readonly fields: readonly ProblemField[]) {
    super(fields.map(({ loc, message }) => `${loc}: ${message}`).join('; '));
  }
}

/** A change that takes more than the page has: its inputs, or tables of another map. */
export class Beyond extends Error {}

/** Fields that decide the inputs of a run, which are those of the shipped scenario. */
const INPUTS =
  /^(trajectory|load|seed|schedule|window|plant\.[xy]\.(encoder\.noise|amplifiers\.(noise|ripple_\w+)))(\.|$)/;

/**
 * Returns the lanes of a shipped scenario with changes.
 *
 * @throws Refused, Beyond
 */
export function changedLanes(
  code: LaneCode,
  lanes: Lanes,
  shipped: Scenario,
  changed: Scenario,
): Lanes {
  check(code, shipped, changed);
  const { epochs, tabled, period } = lanes;
  const names = Object.keys(changed.variants);
  const count = code.PARAMETERS.length;
  const numbers = lanes.lanes.slice();
  epochs.forEach((tick, epoch) => {
    const scenario = inEffect(changed, tick, period);
    names.forEach((name, i) => {
      AXES.forEach((axis, lane) => {
        code.rows(scenario, name, axis).forEach((value, row) => {
          const place = ((epoch * names.length + i) * count + row) * LANES + lane;
          if (value !== undefined) numbers[place] = value;
        });
      });
    });
  });
  const windows = lanes.windows.map((window) => {
    const scenario = inEffect(changed, window.end - 1, period);
    const heads = Object.entries(window.variants).map(([name, head]) => {
      const { law, enabled } = at(scenario, `variants.${name}.controller.compensation`) as {
        law: string;
        enabled: boolean;
      };
      const same = equal(shipped.variants[name], changed.variants[name]);
      return [name, { ...head, law, enabled, notes: same ? head.notes : [] }] as const;
    });
    const settling_band = changed.settling_band;
    return { ...window, settling_band, variants: Object.fromEntries(heads) };
  });
  return {
    ...lanes,
    lanes: numbers,
    windows,
    tabled: tabled.map((_, i) => readsTables(code, numbers, epochs.length, names.length, i)),
  };
}

/** The parameters that hold from a tick on. */
function inEffect(scenario: Scenario, tick: number, period: number): Scenario {
  return scenario.schedule
    .filter(({ time }) => Math.round(time / period) <= tick)
    .reduce((before, { set }) => withChanges(before, set as Changes), scenario);
}

/** Whether a variant runs in the kernel with tables. */
function readsTables(
  { PARAMETERS, LEAST_NORM }: LaneCode,
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
        value(epoch, 'force_model.sharing.law', lane) !== LEAST_NORM,
    ),
  );
  if (tabled[0] !== tabled[1]) throw new Beyond('one axis alone reads a table');
  return tabled[0] as boolean;
}

function check(code: LaneCode, shipped: Scenario, changed: Scenario): void {
  if (!equal(Object.keys(shipped.variants), Object.keys(changed.variants))) {
    throw new Beyond('the scenario has other variants');
  }
  const changes = difference(
    { ...shipped, plant: { ...shipped.plant, name: '' } },
    {
      ...changed,
      plant: { ...changed.plant, name: '' },
    },
  );
  for (const { path, from, to } of changes) {
    if (INPUTS.test(path)) throw new Beyond(`${path} decides the inputs of the run`);
    if (/force_map(\.|$)/.test(path) && [from, to].some(isTableMap)) {
      throw new Beyond('another force map is a table');
    }
  }
  const problems = [
    ...changes.flatMap(({ path, to }) => outOfRange(path, to)),
    ...Object.keys(changed.variants).flatMap((name) => ofVariant(code, changed, name)),
    ...AXES.flatMap((axis) => ofPlant(code, changed, axis)),
  ];
  if (problems.length > 0) throw new Refused(problems);
}

function isTableMap(value: unknown): boolean {
  return typeof value === 'string';
}

/** A number, or one of a list, beyond the bounds of its field. */
export function outOfRange(path: string, value: Value | undefined): ProblemField[] {
  if (Array.isArray(value)) return value.flatMap((each, i) => outOfRange(`${path}.${i}`, each));
  const entry = entryOf(path);
  if (typeof value !== 'number' || !entry?.bounds) return [];
  const { bounds } = entry;
  const { minimum, maximum, exclusive_minimum: above, exclusive_maximum: below } = bounds;
  const holds =
    value >= (minimum ?? Number.NEGATIVE_INFINITY) &&
    value <= (maximum ?? Number.POSITIVE_INFINITY) &&
    value > (above ?? Number.NEGATIVE_INFINITY) &&
    value < (below ?? Number.POSITIVE_INFINITY);
  return holds ? [] : [{ loc: path, message: 'is out of range', value, bounds }];
}

interface Friction {
  enabled: boolean;
  sigma_0: number;
  sigma_1: number;
  F_c: number;
  F_s: number;
}

/** Stiction below Coulomb friction. */
function ofFriction(loc: string, { F_c, F_s }: Friction): ProblemField[] {
  if (F_s >= F_c) return [];
  return [{ loc, message: `F_s = ${F_s} N is below F_c = ${F_c} N`, value: F_s }];
}

function ofVariant(code: LaneCode, scenario: Scenario, name: string): ProblemField[] {
  const owner = `variants.${name}.controller`;
  const compensation = at(scenario, `${owner}.compensation`) as object;
  return AXES.flatMap((axis) => {
    const model = at(scenario, `${owner}.model.${axis}`) as unknown as { friction: Friction };
    const refusal = code.refusal(compensation, model);
    const unstable = refusal && {
      loc: `${owner}.compensation.${refusal.parameter}`,
      message: `is unstable on ${axis}: ${refusal.reason}`,
      value: refusal.value,
      bounds: { exclusive_maximum: refusal.limit },
    };
    const friction = ofFriction(`${owner}.model.${axis}.friction.F_s`, model.friction);
    return [...(unstable ? [unstable] : []), ...friction];
  });
}

/** A mass too small for the stiffnesses and dampings about it, at the explicit step. */
function ofPlant({ PLANT_STEP: h }: LaneCode, scenario: Scenario, axis: string): ProblemField[] {
  const plant = at(scenario, `plant.${axis}`) as unknown as {
    mass: number;
    stop_damping: number;
    stop_stiffness: number;
    friction: Friction;
  };
  const { sigma_0, sigma_1 } = plant.friction.enabled ? plant.friction : { sigma_0: 0, sigma_1: 0 };
  const least = Math.max(
    h * plant.stop_damping,
    h * h * plant.stop_stiffness,
    h * h * sigma_0,
    h * sigma_1,
  );
  const light = {
    loc: `plant.${axis}.mass`,
    message: 'is too small for the stiffness and damping about it at the simulated step',
    value: plant.mass,
    bounds: { minimum: least },
  };
  return [
    ...(plant.mass < least ? [light] : []),
    ...ofFriction(`plant.${axis}.friction.F_s`, plant.friction),
  ];
}
