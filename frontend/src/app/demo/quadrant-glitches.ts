/** What an error does where an axis reverses, as analysis/glitches.py measures it. */

type Values = Float64Array;

/** s */
const AVERAGED = 5e-3;
const BEFORE = 20e-3;
const SHARE = 0.1;
const NOISE = 3;

/** The height at each reversal. */
export function glitches(
  velocity: Values,
  error: Values,
  count: number,
  period: number,
): { tick: number; height: number }[] {
  const before = Math.max(1, Math.round(BEFORE / period));
  const span = Math.max(1, Math.round(AVERAGED / period));
  const moving = [...velocity.keys()].filter((i) => Math.abs(at(velocity, i)) >= 1e-9);
  const turns = moving.filter(
    (tick, i) => i > 0 && at(velocity, tick) > 0 !== at(velocity, at(moving, i - 1)) > 0,
  );
  return turns.flatMap((tick, i) => {
    if (tick < before) return [];
    const around = error.slice(tick - before, turns[i + 1] ?? error.length);
    if (!around.every(Number.isFinite)) return [];
    const mean = averaged(around, span);
    const base = mean.slice(0, before);
    const level = meanOf(base);
    const noise = Math.max(
      count,
      NOISE * Math.sqrt(meanOf(base.map((each) => (each - level) ** 2))),
    );
    const change = mean.slice(before).map((each) => each - level);
    const up = at(change, peakOf(change, noise));
    const down = at(
      change,
      peakOf(
        change.map((each) => -each),
        noise,
      ),
    );
    return [{ tick, height: Math.abs(down) > Math.abs(up) ? down : up }];
  });
}

/** The first maximum from which a deviation comes back, or the largest of all. */
function peakOf(deviation: Values, noise: number): number {
  let best = 0;
  for (let i = 0; i < deviation.length; i++) {
    if (at(deviation, i) > at(deviation, best)) best = i;
    const highest = at(deviation, best);
    if (highest - at(deviation, i) > Math.max(SHARE * highest, noise)) break;
  }
  return best;
}

/** The mean of some ticks around each; at both ends the outermost value goes on. */
function averaged(values: Values, ticks: number): Values {
  const end = values.length - 1;
  return values.map((_, i) => {
    let total = 0;
    for (let k = 0; k < ticks; k++) {
      total += at(values, Math.min(Math.max(i - Math.floor(ticks / 2) + k, 0), end));
    }
    return total / ticks;
  });
}

function meanOf(values: Values): number {
  return values.reduce((total, value) => total + value, 0) / values.length;
}

function at(values: ArrayLike<number>, k: number): number {
  return values[k] as number;
}
