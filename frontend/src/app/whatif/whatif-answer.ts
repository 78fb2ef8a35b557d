/** The binary answer of a what-if: a result document and the curves of its window. */

import { StillSource } from '../../plot/source';
import { addDifferences, readCurves } from '../api/curves-answer';
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
  addDifferences(columns);
  const source = new StillSource(time.start, time.step, time.count, columns);
  return { result, how, begin, source };
}
