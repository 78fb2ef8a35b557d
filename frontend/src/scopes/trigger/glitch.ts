/** The height of a quadrant glitch in a capture, as motionlab/analysis/glitches.py measures it. */

/** Time over which the error is averaged, and before a reversal over which it is what it was, s. */
const AVERAGED = 5e-3;
const BEFORE = 20e-3;
/** Of the height: how far the error comes back after its peak. */
const SHARE = 0.1;
/** Standard deviations of the error before a reversal, below which its height is noise. */
const NOISE = 3;

interface Reversal {
  tick: number;
  end: number;
}

/** Samples at which a reference reverses, also after a rest, and where the new direction ends. */
function reversals(velocity: ArrayLike<number>): Reversal[] {
  const turns: number[] = [];
  let moving = 0;
  for (let i = 0; i < velocity.length; i++) {
    const way = Math.sign(velocity[i] as number);
    if (way === 0 || Number.isNaN(way)) continue;
    if (moving !== 0 && way !== moving) turns.push(i);
    moving = way;
  }
  return turns.map((tick, i) => ({ tick, end: turns[i + 1] ?? velocity.length }));
}

/**
 * Returns the height at the reversal nearest to a sample, signed, m; null without one.
 *
 * @param count of the encoder, m; 0 where it is not known
 */
export function glitchHeight(
  velocity: ArrayLike<number>,
  error: ArrayLike<number>,
  { trigger, count, period }: { trigger: number; count: number; period: number },
): number | null {
  const before = Math.max(1, Math.round(BEFORE / period));
  const known = ({ tick, end }: Reversal) => {
    if (tick < before) return false;
    for (let i = tick - before; i < end; i++) if (!Number.isFinite(error[i])) return false;
    return true;
  };
  const [nearest] = reversals(velocity)
    .filter(known)
    .sort((a, b) => Math.abs(a.tick - trigger) - Math.abs(b.tick - trigger));
  if (!nearest) return null;
  const around = Array.from(
    { length: nearest.end - nearest.tick + before },
    (_, i) => error[nearest.tick - before + i] as number,
  );
  const mean = averaged(around, Math.max(1, Math.round(AVERAGED / period)));
  const base = mean.slice(0, before);
  const level = base.reduce((sum, value) => sum + value, 0) / before;
  const spread = Math.sqrt(base.reduce((sum, value) => sum + (value - level) ** 2, 0) / before);
  const noise = Math.max(count, NOISE * spread);
  const deviation = mean.slice(before).map((value) => value - level);
  const up = peak(deviation, noise);
  const down = -peak(
    deviation.map((value) => -value),
    noise,
  );
  return Math.abs(down) > Math.abs(up) ? down : up;
}

/** The first maximum from which a deviation comes back, or the largest of all. */
function peak(deviation: readonly number[], noise: number): number {
  let highest = Number.NEGATIVE_INFINITY;
  for (const value of deviation) {
    if (value > highest) highest = value;
    if (highest - value > Math.max(SHARE * highest, noise)) break;
  }
  return highest;
}

/** The mean of some samples around each; at both ends the outermost value goes on. */
function averaged(values: readonly number[], ticks: number): number[] {
  const last = values.length - 1;
  const left = Math.floor(ticks / 2);
  return values.map((_, i) => {
    let sum = 0;
    for (let k = i - left; k < i - left + ticks; k++) {
      sum += values[Math.min(last, Math.max(0, k))] as number;
    }
    return sum / ticks;
  });
}
