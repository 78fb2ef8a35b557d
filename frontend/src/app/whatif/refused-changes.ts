/** Changes that the server would refuse, of those that the page can judge, in the server's words. */

import { AXES } from '../../kernel/module';
import { ApiError } from '../api/client';
import { at, type ScenarioDifference } from '../api/scenario-paths';
import type { FieldEntry, ProblemField, Scenario, Value } from '../api/types';
import { entryOf } from '../fields/fields.svelte';
import type { LaneCode } from './changed-lanes';

export type Bounds = NonNullable<FieldEntry['bounds']>;

/** A change that the server will refuse, as far as the page can tell. */
export class Refused extends ApiError {
  constructor(errors: ProblemField[]) {
    const detail = errors.map(({ loc, message }) => `${loc}: ${message}`).join('; ');
    super({ title: 'Refused', status: 422, detail, errors });
  }
}

/**
 * Checks ranges, stiction, the least mass and the stability of laws, in the order of the server: what lies
 * inside a refused value, or follows from it, is not checked.
 *
 * @throws Refused
 */
export function refuse(
  code: LaneCode,
  changed: Scenario,
  changes: readonly ScenarioDifference[],
): void {
  const problems = changes.flatMap(({ path, to }) => outOfRange(path, to));
  const variants = Object.keys(changed.variants);
  const plants = AXES.map((axis) => `plant.${axis}`);
  const models = variants.flatMap((name) =>
    AXES.map((axis) => `variants.${name}.controller.model.${axis}`),
  );
  const checkAt = (loc: string, message: string | null) => {
    const refused = problems.some((each) => `${each.loc}.`.startsWith(`${loc}.`));
    if (message !== null && !refused) problems.push({ loc, message });
  };
  for (const owner of [...plants, ...models]) {
    checkAt(`${owner}.friction`, ofFriction(at(changed, `${owner}.friction`)));
  }
  for (const loc of plants) checkAt(loc, ofMass(code, at(changed, loc)));
  if (problems.length === 0) {
    problems.push(...variants.flatMap((name) => ofLaw(code, changed, name)));
  }
  if (problems.length > 0) throw new Refused(problems);
}

/** A number, or one of a list, beyond the bounds of its field, which may be given. */
export function outOfRange(path: string, value: Value | undefined, own?: Bounds): ProblemField[] {
  if (Array.isArray(value))
    return value.flatMap((each, i) => outOfRange(`${path}.${i}`, each, own));
  const entry = entryOf(path);
  const bounds = own ?? entry?.bounds;
  if (typeof value !== 'number' || !bounds) return [];
  const { minimum, maximum, exclusive_minimum: above, exclusive_maximum: below } = bounds;
  const holds =
    value >= (minimum ?? Number.NEGATIVE_INFINITY) &&
    value <= (maximum ?? Number.POSITIVE_INFINITY) &&
    value > (above ?? Number.NEGATIVE_INFINITY) &&
    value < (below ?? Number.POSITIVE_INFINITY);
  const unit = entry?.unit ?? '';
  return holds ? [] : [{ loc: path, message: 'is out of range', value, bounds, unit }];
}

/** A number as Python's `:g` writes it, or with other significant digits. */
function general(value: number, significant = 6): string {
  return String(Number(value.toPrecision(significant)));
}

/** Stiction below Coulomb friction. */
function ofFriction(friction: Value | undefined): string | null {
  const { F_c, F_s } = friction as unknown as { F_c: number; F_s: number };
  return F_s >= F_c ? null : `F_s = ${general(F_s)} N is below F_c = ${general(F_c)} N`;
}

/** A mass too small for the stiffnesses and dampings about it, at the explicit step. */
function ofMass({ PLANT_STEP: h }: LaneCode, plant: Value | undefined): string | null {
  const { mass, stop_damping, stop_stiffness, friction } = plant as unknown as {
    mass: number;
    stop_damping: number;
    stop_stiffness: number;
    friction: { enabled: boolean; sigma_0: number; sigma_1: number };
  };
  const { sigma_0, sigma_1 } = friction.enabled ? friction : { sigma_0: 0, sigma_1: 0 };
  const needs = {
    stop_damping: h * stop_damping,
    stop_stiffness: h * h * stop_stiffness,
    'friction.sigma_0': h * h * sigma_0,
    'friction.sigma_1': h * sigma_1,
  };
  const least = Math.max(...Object.values(needs));
  if (mass >= least) return null;
  const [cause] = Object.entries(needs).find(([, need]) => need === least) ?? [''];
  return (
    `mass = ${general(mass)} kg is too small for ${cause}: ` +
    `steps of ${general(h * 1e6)} us need >= ${general(least, 4)} kg`
  );
}

/** Gains with which the law is unstable by itself, on the axis that allows least. */
function ofLaw(code: LaneCode, scenario: Scenario, name: string): ProblemField[] {
  const owner = `variants.${name}.controller`;
  const compensation = at(scenario, `${owner}.compensation`) as object;
  const refusals = AXES.flatMap((axis) => {
    const refusal = code.refusal(compensation, at(scenario, `${owner}.model.${axis}`) as object);
    return refusal ? [{ axis, ...refusal }] : [];
  });
  const [least] = refusals.sort((a, b) => a.limit - b.limit);
  if (!least) return [];
  const { axis, parameter, reason, value, limit } = least;
  const loc = `${owner}.compensation.${parameter}`;
  const { bounds = null, unit = '' } = entryOf(loc) ?? {};
  const { minimum } = bounds ?? {};
  return [
    {
      loc,
      message: `is unstable on ${axis}: ${reason}`,
      value,
      bounds: { ...(minimum === undefined ? {} : { minimum }), exclusive_maximum: limit },
      unit,
    },
  ];
}
