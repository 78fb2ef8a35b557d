/**
 * Steps of a compiled expression, run on one sample after another.
 *
 * The server compiles: POST /expressions/check. What is not finite is a gap, NaN; at the first sample,
 * and after every gap, operations with memory begin anew, as docs/expressions.md has it.
 */

export interface Step {
  op: string;
  values: readonly number[];
}

type Unary = (u: number) => number;
type Binary = (u: number, v: number) => number;

const UNARY: Readonly<Record<string, Unary>> = {
  negate: (u) => -u,
  abs: Math.abs,
  sqrt: Math.sqrt,
  sign: Math.sign,
  sin: Math.sin,
  cos: Math.cos,
};

const BINARY: Readonly<Record<string, Binary>> = {
  add: (u, v) => u + v,
  subtract: (u, v) => u - v,
  multiply: (u, v) => u * v,
  divide: (u, v) => u / v,
  minimum: Math.min,
  maximum: Math.max,
  hypot: Math.hypot,
};

/** An operation on the top of the stack. */
type Operation =
  | { kind: 'channel'; place: number }
  | { kind: 'number'; value: number }
  | { kind: 'unary'; of: Unary; reset?: () => void }
  | { kind: 'binary'; of: Binary };

export class Evaluator {
  private readonly operations: readonly Operation[];
  private readonly stack: Float64Array;

  constructor(steps: readonly Step[]) {
    this.operations = steps.map(operationOf);
    this.stack = new Float64Array(steps.length + 1);
  }

  /** Forgets what came before. */
  reset(): void {
    for (const each of this.operations) if (each.kind === 'unary') each.reset?.();
  }

  /** The value at the next sample, whose channels `channel` returns by their place. */
  next(channel: (place: number) => number): number {
    const { operations, stack } = this;
    let top = -1;
    for (const each of operations) {
      let value: number;
      switch (each.kind) {
        case 'channel':
          value = channel(each.place);
          top += 1;
          break;
        case 'number':
          ({ value } = each);
          top += 1;
          break;
        case 'unary':
          value = each.of(stack[top] as number);
          break;
        case 'binary':
          top -= 1;
          value = each.of(stack[top] as number, stack[top + 1] as number);
          break;
      }
      stack[top] = Number.isFinite(value) ? value : Number.NaN;
    }
    const result = Math.fround(stack[0] as number);
    return Number.isFinite(result) ? result : Number.NaN;
  }
}

function operationOf({ op, values }: Step): Operation {
  const [first = Number.NaN] = values;
  if (op === 'channel') return { kind: 'channel', place: first };
  if (op === 'number') return { kind: 'number', value: first };
  const of = BINARY[op];
  if (of) return { kind: 'binary', of };
  if (op === 'filter') return filter(values);
  if (op === 'difference') return difference(first);
  if (op === 'mean') return mean(first);
  if (op === 'delay') return delay(first);
  if (op === 'power') return { kind: 'unary', of: (u) => power(u, first) };
  const unary = UNARY[op];
  if (!unary) throw new Error(`no operation ${op}`);
  return { kind: 'unary', of: unary };
}

/** A whole power by multiplication, as the server computes it. */
function power(u: number, exponent: number): number {
  let result = 1;
  for (let i = 0; i < Math.abs(exponent); i++) result *= u;
  return exponent < 0 ? 1 / result : result;
}

/** y_k = a y_(k-1) + b0 u_k + b1 u_(k-1), and y = g u at the first sample after a gap. */
function filter([a = 0, b0 = 0, b1 = 0, g = 0]: readonly number[]): Operation {
  let y = Number.NaN;
  let last = Number.NaN;
  const of = (u: number) => {
    y = Number.isNaN(y) || Number.isNaN(u) ? g * u : a * y + b0 * u + b1 * last;
    if (!Number.isFinite(y)) y = Number.NaN;
    last = u;
    return y;
  };
  return { kind: 'unary', of, reset: () => (y = Number.NaN) };
}

function difference(gain: number): Operation {
  let last = Number.NaN;
  const of = (u: number) => {
    const result = gain * (u - last);
    last = u;
    return result;
  };
  return { kind: 'unary', of, reset: () => (last = Number.NaN) };
}

/** The mean of the last samples; the sum is taken anew each time that the ring is full. */
function mean(size: number): Operation {
  const ring = new Float64Array(size);
  let [total, count, place] = [0, 0, 0];
  const reset = () => ([total, count, place] = [0, 0, 0]);
  const of = (u: number) => {
    if (Number.isNaN(u)) {
      reset();
      return u;
    }
    if (count === size) total -= ring[place] as number;
    else count += 1;
    ring[place] = u;
    total += u;
    place += 1;
    if (place === size) {
      place = 0;
      total = 0;
      for (const each of ring) total += each;
    }
    return total / count;
  };
  return { kind: 'unary', of, reset };
}

function delay(size: number): Operation {
  const ring = new Float64Array(size).fill(Number.NaN);
  let place = 0;
  const of = (u: number) => {
    const result = ring[place] as number;
    ring[place] = u;
    place = (place + 1) % size;
    return result;
  };
  return { kind: 'unary', of, reset: () => void ring.fill(Number.NaN) };
}
