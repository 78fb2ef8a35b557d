/** Where curves meet conditions: the moments at which a scope is triggered, sample by sample. */

export type Slope = 'rising' | 'falling' | 'either';
export type Way = 'leaves' | 'enters';

/** A curve passes a level; below it by the hysteresis (above, falling) it is armed again. */
export interface LevelCondition {
  kind: 'level';
  channel: string;
  slope: Slope;
  level: number;
  hysteresis: number;
}

/** A curve leaves or enters a band; inside it by the hysteresis it counts as back. */
export interface WindowCondition {
  kind: 'window';
  channel: string;
  way: Way;
  low: number;
  high: number;
  hysteresis: number;
}

/** A velocity changes its sign, also after a rest: at the first sample that moves the new way. */
export interface ReversalCondition {
  kind: 'reversal';
  channel: string;
  /** The sign that it changes to. */
  slope: Slope;
}

/** Something that is marked on the time axis: a change, the schedule, a push. */
export interface MarkCondition {
  kind: 'mark';
}

export type Condition = LevelCondition | WindowCondition | ReversalCondition | MarkCondition;
export type Join = 'and' | 'or';

/** What a condition says of one sample: whether it holds, and whether it has begun to just now. */
interface Said {
  holds: boolean;
  edge: boolean;
}

const NOT: Said = { holds: false, edge: false };

/** A state with two thresholds: which of two sides a curve is on, unknown before its first sample. */
class TwoSided {
  private side: boolean | null = null;

  /** Tells of a sample whether it is on the upper side by itself, and whether on the lower one. */
  next(upper: boolean, lower: boolean): { side: boolean; turned: boolean } {
    const before = this.side;
    if (before === null) this.side = upper;
    else if (upper) this.side = true;
    else if (lower) this.side = false;
    return { side: this.side as boolean, turned: before !== null && this.side !== before };
  }
}

type Watch = (value: number, tick: number) => Said;

function watchLevel({ slope, level, hysteresis }: LevelCondition): Watch {
  const state = new TwoSided();
  // The level is where it triggers; the hysteresis lies on the side from which it comes.
  const [on, off] = {
    rising: [level, level - hysteresis],
    falling: [level + hysteresis, level],
    either: [level + hysteresis / 2, level - hysteresis / 2],
  }[slope] as [number, number];
  return (value) => {
    const above = slope === 'falling' ? value > on : value >= on;
    const below = slope === 'falling' ? value <= off : value < off;
    const { side, turned } = state.next(above, below);
    if (slope === 'either') return { holds: turned, edge: turned };
    const holds = side === (slope === 'rising');
    return { holds, edge: turned && holds };
  };
}

function watchWindow({ way, low, high, hysteresis }: WindowCondition): Watch {
  const state = new TwoSided();
  return (value) => {
    const outside = value < low || value > high;
    const back = value >= low + hysteresis && value <= high - hysteresis;
    const { side, turned } = state.next(outside, back);
    const holds = side === (way === 'leaves');
    return { holds, edge: turned && holds };
  };
}

function watchReversal({ slope }: ReversalCondition): Watch {
  const direction = { rising: 1, falling: -1, either: 0 }[slope];
  let moving = 0;
  return (value) => {
    const way = Math.sign(value);
    if (way === 0) return NOT;
    const turned = moving !== 0 && way !== moving && (direction === 0 || way === direction);
    moving = way;
    return { holds: turned, edge: turned };
  };
}

function watchMarks(marks: () => readonly number[], period: number): Watch {
  return (_, tick) => {
    const edge = marks().some((time) => Math.round(time / period) === tick);
    return { holds: edge, edge };
  };
}

/** The channels that conditions look at, each once. */
export function channelsOf(conditions: readonly Condition[]): string[] {
  return [...new Set(conditions.flatMap((each) => ('channel' in each ? [each.channel] : [])))];
}

/**
 * Meets samples in their order. With `or` the beginning of any condition triggers; with `and` the
 * beginning of one while all others hold. After a hit nothing triggers for the hold-off.
 */
export class Detector {
  private readonly watches: readonly { watch: Watch; place: number }[];
  private last = Number.NEGATIVE_INFINITY;

  /**
   * @param holdOff in ticks
   * @param marks times of what is marked, s
   */
  constructor(
    conditions: readonly Condition[],
    private readonly join: Join,
    private readonly holdOff: number,
    marks: () => readonly number[],
    period: number,
  ) {
    const channels = channelsOf(conditions);
    this.watches = conditions.map((condition) => ({
      place: 'channel' in condition ? channels.indexOf(condition.channel) : -1,
      watch: {
        level: () => watchLevel(condition as LevelCondition),
        window: () => watchWindow(condition as WindowCondition),
        reversal: () => watchReversal(condition as ReversalCondition),
        mark: () => watchMarks(marks, period),
      }[condition.kind](),
    }));
  }

  /** Takes the samples of one tick, in the order of `channelsOf`; whether it is a hit. */
  next(tick: number, values: readonly number[]): boolean {
    let [any, all] = [false, true];
    for (const { watch, place } of this.watches) {
      const value = place < 0 ? 0 : (values[place] ?? Number.NaN);
      // Of a gap nothing is known: what held before it may hold on.
      const state = Number.isNaN(value) ? NOT : watch(value, tick);
      any ||= state.edge;
      all &&= state.holds;
    }
    const hit = any && (this.join === 'or' || all) && tick - this.last >= this.holdOff;
    if (hit) this.last = tick;
    return hit;
  }
}
