/** The forces of one axis at a moment: which phase pulls, what holds against it. */

import { numberAt } from '../../../app/api/scenario-paths';
import type { MapTables } from '../../../app/api/types';
import { minus, quantity } from '../../../ui/units';

export const PHASES = ['a', 'b', 'c'] as const;

/** A, from where on a phase counts as carrying current. */
export const CARRIES = 0.05;
/** N, below which a force is not spoken of. */
const LEAST = 0.05;
/** Share of the largest thrust below which a phase is not spoken of. */
const MINOR = 0.1;

/** Thrust of a phase over its angle and current. */
export interface ForceMap {
  /** Pole pitch and shift of the map against the encoder, m. */
  pitch: number;
  offset: number;
  /** N; of an angle in turns, 1/2 of which is aligned, and a current, A. */
  thrust(turns: number, current: number): number;
}

/** The formula of docs/physics: F(i) S(theta). */
export function analyticMap(axis: object): ForceMap | null {
  const read = (name: string) => numberAt(axis, `force_map.${name}`);
  const [pitch, peak, rated, knee] = [read('tau'), read('F_pk'), read('I_pk'), read('I_knee')];
  if (!(pitch > 0)) return null;
  const [h2, h3] = [read('h_2'), read('h_3')];
  const b = (rated / knee) ** 2;
  return {
    pitch,
    offset: read('offset'),
    thrust(turns, current) {
      const q = (current / rated) ** 2;
      const angle = 2 * Math.PI * turns;
      const shape = Math.sin(angle) + h2 * Math.sin(2 * angle) + h3 * Math.sin(3 * angle);
      return (((peak * (1 + b) * q) / (1 + b * q)) * shape) / (1 - h3);
    },
  };
}

/** A map by finite elements, between the values of its table. */
export function tableMap(axis: object, map: MapTables): ForceMap {
  const pitch = map.geometry.tau;
  const gain = numberAt(axis, 'force_map.gain');
  const { currents, thrust } = map;
  const first = map.positions[0] ?? 0;
  // The end of the pitch is its begin once more.
  const positions = [...map.positions, first + pitch];
  const last = currents.length - 1;
  return {
    pitch,
    offset: numberAt(axis, 'force_map.offset'),
    thrust(turns, current) {
      const x = (turns - 0.5) * pitch;
      const from = x - Math.floor((x - first) / pitch) * pitch;
      const row = between(positions, from);
      const column = between(currents, Math.min(Math.abs(current), currents[last] ?? 0));
      const at = (i: number, k: number) =>
        thrust[i % map.positions.length]?.[Math.min(k, last)] ?? 0;
      const mix = (i: number) =>
        at(i, column.i) + column.share * (at(i, column.i + 1) - at(i, column.i));
      return gain * (mix(row.i) + row.share * (mix(row.i + 1) - mix(row.i)));
    },
  };
}

/** The place of a value among rising ones: the interval and the share of it. */
function between(values: readonly number[], value: number): { i: number; share: number } {
  let i = 0;
  while (i < values.length - 2 && (values[i + 1] as number) <= value) i += 1;
  const [low, high] = [values[i] as number, values[i + 1] as number];
  return { i, share: high > low ? Math.min(1, Math.max(0, (value - low) / (high - low))) : 0 };
}

/** An axis at a moment; NaN of what is not there. */
export interface AxisState {
  reference: number;
  error: number;
  currents: readonly number[];
  thrust: number;
  friction: number;
  estimate: number;
}

export function read(
  at: (column: string) => number,
  { variant, axis }: { variant: string; axis: string },
): AxisState {
  const own = (name: string) => at(`${variant}.${axis}.${name}`);
  return {
    reference: at(`${axis}.position_reference`),
    error: own('following_error'),
    currents: PHASES.map((phase) => own(`current_${phase}`)),
    thrust: own('thrust'),
    friction: own('friction'),
    estimate: own('friction_estimate'),
  };
}

/** What `read` reads. */
export function columnsOf(variant: string, axis: string): string[] {
  const own = ['following_error', ...PHASES.map((phase) => `current_${phase}`)];
  return [
    `${axis}.position_reference`,
    ...[...own, 'thrust', 'friction', 'friction_estimate'].map(
      (one) => `${variant}.${axis}.${one}`,
    ),
  ];
}

/** Angle of each phase, turns; the whole part does not matter. */
export function turnsOf({ pitch, offset }: ForceMap, position: number): number[] {
  return PHASES.map((_, k) => (position + offset) / pitch - k / 3);
}

/** Thrust of each phase, N. */
export function phaseThrusts(map: ForceMap, { reference, error, currents }: AxisState): number[] {
  return turnsOf(map, reference - error).map((turns, k) => map.thrust(turns, currents[k] ?? 0));
}

const newtons = (force: number) => {
  const { number, unit } = quantity(Math.abs(force), 'N');
  return `${number} ${unit}`;
};
const sideOf = (force: number) => (force > 0 ? 'right' : 'left');

/** Says what happens: "c pulls to the right with 2.1 N, friction of 2.6 N holds against it." */
export function sentence(state: AxisState, thrusts: readonly number[]): string {
  const withSize = (force: number) => ` with ${newtons(force)}`;
  const largest = Math.max(0, ...thrusts.map(Math.abs));
  const pulling = PHASES.flatMap((phase, k) => {
    const force = thrusts[k] ?? 0;
    const counts = Math.abs(force) >= Math.max(LEAST, MINOR * largest);
    return counts && Math.abs(state.currents[k] ?? 0) > CARRIES ? [{ phase, force }] : [];
  }).sort((one, other) => Math.abs(other.force) - Math.abs(one.force));
  const [first] = pulling;
  const estimated = Number.isNaN(state.friction);
  const friction = -(estimated ? state.estimate : state.friction);
  const name = estimated ? 'estimated friction' : 'friction';
  const rubs = Math.abs(friction) >= LEAST;
  if (!first) {
    return rubs
      ? `No phase pulls; ${name} pushes to the ${sideOf(friction)}${withSize(friction)}.`
      : 'No phase pulls, and nothing holds.';
  }
  const along = pulling.filter(({ force }) => force * first.force > 0);
  const against = pulling.filter(({ force }) => force * first.force < 0);
  const list = (some: typeof pulling) => some.map(({ phase }) => phase).join(' and ');
  const sum = (some: typeof pulling) => some.reduce((all, { force }) => all + force, 0);
  const verb = (some: typeof pulling) => (some.length > 1 ? 'pull' : 'pulls');
  const parts = [
    `${list(along)} ${verb(along)} to the ${sideOf(first.force)}${withSize(sum(along))}`,
  ];
  if (against.length > 0) {
    parts.push(`${list(against)} ${verb(against)} back${withSize(sum(against))}`);
  }
  if (rubs) {
    const holds = friction * sum(pulling) < 0 ? 'holds against it' : 'pushes the same way';
    parts.push(`${name} of ${newtons(friction)} ${holds}`);
  }
  return `${parts.join(', ')}.`;
}

/** A signed force as a label has it. */
export function forceText(force: number, places = 2): string {
  return Number.isFinite(force) ? minus(`${force.toFixed(places)} N`) : '–';
}
