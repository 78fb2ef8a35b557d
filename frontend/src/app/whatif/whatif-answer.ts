/** The binary answer of a what-if: a result document and curves over a stretch of its run. */

import { StillSource } from '../../plot/source';
import { readCurves } from '../api/curves-answer';
import type { Metrics } from '../api/types';

export interface Preview {
  result: Metrics;
  /** `window` when the run began at a stored state of the unchanged scenario, at `begin`. */
  how: 'whole' | 'window';
  /** s */
  begin: number;
  /** Of the whole scenario, and of a control period, s. */
  duration: number;
  period: number;
  source: StillSource;
}

interface Header extends Omit<Preview, 'source'> {
  time: { start: number; step: number; count: number };
}

/** Reads an answer of POST /whatif; arrays are views into it. */
export function readAnswer(buffer: ArrayBuffer): Preview {
  const { time, columns, result, how, begin, duration, period } = readCurves<Header>(buffer);
  const source = new StillSource(time.start, time.step, time.count, columns);
  return { result, how, begin, duration, period, source };
}
