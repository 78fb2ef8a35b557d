/** The circular test of a motion that follows a circle, as analysis/ballbar.py defines it. */

import type { components } from '../api/schema';
import { fitted, type Ring, ringOf, unwrapped } from './circle-fit';
import { glitches } from './quadrant-glitches';

type Document = components['schemas']['Ballbar'];
type Variant = components['schemas']['BallbarVariant'];
type One = components['schemas']['BallbarDirection'];
export type Way = 'ccw' | 'cw';

type Values = Float64Array;

/** A whole run: references, and the following errors of each variant that has not diverged. */
export interface Recorded {
  period: number;
  x: Values;
  y: Values;
  errors: Record<string, readonly [x: Values, y: Values]>;
  /** Of the encoders, m. */
  counts: readonly [x: number, y: number];
}

/** Samples [start, stop) are a whole lap; [begin, stop) goes in its direction. */
interface Lap {
  way: Way;
  begin: number;
  start: number;
  stop: number;
}

interface Measured {
  theta: Values;
  F: Values;
  document: One;
  /** Terms of 1, cos, sin, cos 2 theta, sin 2 theta. */
  terms: number[];
}

const GRID = 720;
const TURN = 2 * Math.PI;
const ROUND = 1e-6;
/** What references in single precision are rounded by, m. */
const ROUNDING = 30e-9;
/** How much a lap may miss of a turn, rad. */
const WHOLE = 1e-6;
const SHORTEST = 64;
/** @throws Error where the reference is no circle, or has no whole lap */
export async function circularTest(
  recorded: Recorded,
  names: readonly string[],
  other: (way: Way) => Promise<Recorded | string>,
): Promise<Document> {
  const circle = circleOf(recorded);
  const laps = lapsOf(circle, recorded);
  const [lap] = laps;
  if (!lap) throw new Error('The motion has no whole lap.');
  const rate = Math.max(...laps.map((each) => rateOf(circle, recorded, each)));
  const measured = laps.map((each) => measure(circle, recorded, each, false));
  let note = '';
  if (laps.length === 1) {
    const missing: Way = lap.way === 'ccw' ? 'cw' : 'ccw';
    const turned = await other(missing);
    if (typeof turned === 'string') note = `the other direction cannot be simulated: ${turned}`;
    else {
      const same = circleOf(turned);
      const there = lapsOf(same, turned).filter(({ way }) => way === missing);
      measured.push(...there.map((each) => measure(same, turned, each, true)));
      laps.push(...there);
    }
  }
  const of = (name: string): Variant => {
    const own = new Map<Way, Measured>();
    laps.forEach(({ way }, i) => {
      const each = measured[i]?.[name];
      if (each) own.set(way, each);
    });
    const [ccw, cw] = [own.get('ccw'), own.get('cw')];
    return {
      directions: Object.fromEntries(
        (['ccw', 'cw'] as const).flatMap((way) => {
          const each = own.get(way);
          return each ? [[way, each.document]] : [];
        }),
      ),
      both: ccw && cw ? bothOf(circle.radius, rate, ccw, cw) : null,
    };
  };
  return {
    radius: circle.radius,
    center: [circle.x, circle.y],
    feed: rate * circle.radius,
    step: TURN / GRID,
    variants: Object.fromEntries(names.map((name) => [name, of(name)])),
    note,
  };
}

function circleOf({ x, y }: Recorded): Ring {
  const circle = ringOf(x, y, ROUNDING);
  const off = circle
    ? x.reduce(
        (most, value, i) =>
          Math.max(
            most,
            Math.abs(Math.hypot(value - circle.x, at(y, i) - circle.y) - circle.radius),
          ),
        0,
      )
    : Number.POSITIVE_INFINITY;
  if (circle && off <= ROUNDING + ROUND * circle.radius) return circle;
  throw new Error("The reference is no circle: a ballbar test needs one, such as kind = 'circle'.");
}

/** The last whole lap of each direction in which there is one. */
function lapsOf(circle: Ring, { x, y }: Recorded): Lap[] {
  const angle = unwrapped(x.map((value, i) => Math.atan2(at(y, i) - circle.y, value - circle.x)));
  const step = angle.slice(1).map((value, i) => value - at(angle, i));
  const moving = [...step.keys()].filter((i) => Math.abs(at(step, i)) > ROUNDING / circle.radius);
  const laps = new Map<Way, Lap>();
  for (let first = 0, last = 0; first < moving.length; first = last) {
    const sign = Math.sign(at(step, at(moving, first)));
    while (last < moving.length && Math.sign(at(step, at(moving, last))) === sign) last += 1;
    const [begin, stop] = [at(moving, first), at(moving, last - 1) + 2];
    const end = at(angle, stop - 1);
    const own = Math.abs(at(step, stop - 2));
    if (Math.abs(end - at(angle, begin)) + own < TURN - WHOLE) continue;
    let start = begin;
    while (Math.abs(end - at(angle, start)) >= TURN - Math.max(WHOLE, own / 2)) start += 1;
    const way = sign > 0 ? 'ccw' : 'cw';
    if (stop - start >= SHORTEST) laps.set(way, { way, begin, start, stop });
  }
  return [...laps.values()];
}

function rateOf(circle: Ring, { x, y, period }: Recorded, { start, stop }: Lap): number {
  const angle = unwrapped(
    x
      .slice(start, stop)
      .map((value, i) => Math.atan2(at(y, start + i) - circle.y, value - circle.x)),
  );
  return Math.abs(at(angle, angle.length - 1) - at(angle, 0)) / ((angle.length - 1) * period);
}

function measure(
  circle: Ring,
  { x, y, errors, counts, period }: Recorded,
  lap: Lap,
  simulated: boolean,
): Record<string, Measured> {
  const { begin, start, stop, way } = lap;
  const angle = x
    .slice(begin, stop)
    .map((value, i) => Math.atan2(at(y, begin + i) - circle.y, value - circle.x));
  const entries = Object.entries(errors).flatMap(([name, [errorX, errorY]]) => {
    const [theta, F] = deviation(circle.radius, angle, errorX.slice(begin), errorY.slice(begin));
    const [ownTheta, ownF] = [theta.slice(start - begin), F.slice(start - begin)];
    if (!ownF.every(Number.isFinite)) return [];
    const terms = fitted(shapes(ownTheta, 5), ownF);
    const [mean, offset_x, offset_y, cos_2, sin_2] = terms as [
      number,
      number,
      number,
      number,
      number,
    ];
    const document: One = {
      simulated,
      F_max: largest(ownF),
      F_min: -largest(ownF.map((value) => -value)),
      G: outOfRound(ownTheta, ownF),
      quadrants: quadrants(way, angle, F, {
        counts,
        period,
        least: Math.floor((stop - start) / 8),
      }),
      harmonics: { mean, offset_x, offset_y, cos_2, sin_2 },
      deviation: Array.from(onGrid(ownTheta, ownF), (value) => Math.round(value * 1e12) / 1e12),
    };
    return [[name, { theta: ownTheta, F: ownF, document, terms }] as const];
  });
  return Object.fromEntries(entries);
}

/** Angle, 0 to 2 pi, and radial deviation of the measured position, by the form that loses no digit. */
function deviation(R: number, angle: Values, errorX: Values, errorY: Values): [Values, Values] {
  const [theta, F] = [angle.slice(), angle.slice()];
  angle.forEach((phi, i) => {
    const [across, along] = [Math.cos(phi), Math.sin(phi)];
    const [ex, ey] = [at(errorX, i), at(errorY, i)];
    const [x, y] = [R * across - ex, R * along - ey];
    F[i] = (ex ** 2 + ey ** 2 - 2 * R * (across * ex + along * ey)) / (Math.hypot(x, y) + R);
    const turned = Math.atan2(y, x);
    theta[i] = turned < 0 ? turned + TURN : turned;
  });
  return [theta, F];
}

/** By how much F changes where an axis reverses, at 0, 90, 180 and 270 degrees. */
function quadrants(
  way: Way,
  angle: Values,
  F: Values,
  { counts, period, least }: { counts: readonly number[]; period: number; least: number },
): (number | null)[] {
  const sense = way === 'ccw' ? 1 : -1;
  const heights: (number | null)[] = [null, null, null, null];
  const velocities = [
    angle.map((phi) => -sense * Math.sin(phi)),
    angle.map((phi) => sense * Math.cos(phi)),
  ];
  velocities.forEach((velocity, axis) => {
    for (const { tick, height } of glitches(velocity, F, at(counts, axis), period)) {
      if (velocity.length - tick < least) continue;
      const quarter = Math.round(at(angle, tick) / (Math.PI / 2));
      heights[(quarter + 4) % 4] = height;
    }
  });
  return heights;
}

function bothOf(
  radius: number,
  rate: number,
  ccw: Measured,
  cw: Measured,
): components['schemas']['BallbarBoth'] {
  const mean = ccw.terms.map((value, i) => (value + at(cw.terms, i)) / 2);
  const half = (at(ccw.terms, 4) - at(cw.terms, 4)) / 2;
  const [there, back] = [onGrid(ccw.theta, ccw.F), onGrid(cw.theta, cw.F)];
  const join = (a: Values, b: Values) => Float64Array.from([...a, ...b]);
  return {
    G: outOfRound(join(ccw.theta, cw.theta), join(ccw.F, cw.F)),
    H: largest(there.map((value, i) => Math.abs(value - at(back, i)))),
    radius_error: at(mean, 0),
    offset_x: at(mean, 1),
    offset_y: at(mean, 2),
    squareness: (2 * at(mean, 4)) / radius,
    scale_mismatch: (2 * at(mean, 3)) / radius,
    servo_mismatch: (2 * half) / (radius * rate),
  };
}

/** Largest less least distance from the centre of the least-squares circle. */
function outOfRound(theta: Values, F: Values): number {
  const columns = shapes(theta, 3);
  const terms = fitted(columns, F);
  const left = F.map(
    (value, i) => value - terms.reduce((sum, a, k) => sum + a * at(columns[k] ?? [], i), 0),
  );
  return largest(left) + largest(left.map((value) => -value));
}

function shapes(theta: Values, terms: number): Values[] {
  const all = [
    () => 1,
    Math.cos,
    Math.sin,
    (a: number) => Math.cos(2 * a),
    (a: number) => Math.sin(2 * a),
  ];
  return all.slice(0, terms).map((shape) => theta.map((angle) => shape(angle)));
}

/** The mean of F over each half degree; straight lines over those without a sample. */
function onGrid(theta: Values, F: Values): Values {
  const [total, count] = [new Float64Array(GRID), new Float64Array(GRID)];
  theta.forEach((angle, i) => {
    const place = Math.min(Math.floor(angle * (GRID / TURN)), GRID - 1);
    (total[place] as number) += at(F, i);
    (count[place] as number) += 1;
  });
  const known = [...count.keys()].filter((place) => at(count, place) > 0);
  return total.map((_, place) => {
    const after = known.findIndex((each) => each >= place);
    const next = at(known, after < 0 ? 0 : after);
    const last = at(known, after <= 0 ? known.length - 1 : after - 1);
    const [a, b] = [last, next].map((each) => at(total, each) / at(count, each)) as [
      number,
      number,
    ];
    const gap = (next - last + GRID) % GRID || GRID;
    return next === place ? b : a + ((b - a) * ((place - last + GRID) % GRID)) / gap;
  });
}

function largest(values: Values): number {
  return values.reduce((most, value) => Math.max(most, value), Number.NEGATIVE_INFINITY);
}

function at(values: ArrayLike<number>, k: number): number {
  return values[k] as number;
}
