/** The binary answer of a what-if: a result document and the curves of its window. */

import { StillSource, differenceName, type Envelope } from '../../plot/source';
import { readCurves } from '../api/curves-answer';
import type { Metrics } from '../api/types';

export interface Preview {
  result: Metrics;
  /** `window` when the run began at a stored state of the unchanged scenario, at `begin`. */
  how: 'whole' | 'window';
  /** s */
  begin: number;
  source: StillSource;
}

interface Header {
  result: Metrics;
  time: { start: number; step: number; count: number };
  how: 'whole' | 'window';
  begin: number;
}

/** Reads an answer of POST /whatif; arrays are views into it. */
export function readAnswer(buffer: ArrayBuffer): Preview {
  const { result, time, columns, how, begin } = readCurves<Header>(buffer);
  for (const axis of ['x', 'y']) {
    const a = columns.get(`A.${axis}.following_error`);
    const b = columns.get(`B.${axis}.following_error`);
    if (!a || !b) continue;
    columns.set(differenceName(`${axis}.following_error`, 'A', 'B'), middles(a, b));
  }
  const source = new StillSource(time.start, time.step, time.count, columns);
  return { result, how, begin, source };
}

/** A less B at the middle of each bin: extremes of a difference do not follow from extremes. */
function middles(a: Envelope, b: Envelope): Envelope {
  const values = new Float32Array(a.minimum.length);
  for (let i = 0; i < values.length; i++) {
    const of = (e: Envelope) => ((e.minimum[i] as number) + (e.maximum[i] as number)) / 2;
    values[i] = of(a) - of(b);
  }
  return { minimum: values, maximum: values };
}
