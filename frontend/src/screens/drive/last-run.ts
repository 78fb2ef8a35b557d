/** Whether a run on drives can be held against its simulation, and what is drawn of both. */

import { AXES, type ChannelComparison, type Comparison, type RunDetail } from '../../app/api/types';
import { USUAL, type How } from '../../parts/compare/compare-request';
import { stopText } from '../../parts/runs/run-text';
import { durationText, pretty } from '../../ui/units';

/** Least recorded time of a run that says anything, s. */
const SHORTEST = 0.1;
/** An axis whose reference moves by less stands still, m. */
const AT_REST = 1e-6;

type Judged = Pick<
  RunDetail,
  'state' | 'reason' | 'stopped' | 'stopped_at' | 'duration' | 'scenario_document'
>;

/** Why a run is not held against a simulation; empty where it can be. */
export function whyNotJudged(run: Judged): string {
  if (run.state === 'recording') return 'It is being recorded.';
  if (run.scenario_document === null) {
    return 'The run has no scenario, so there is nothing to simulate.';
  }
  if (run.stopped !== '') {
    return `${stopText(run)}. Only a motion to its end is judged here; Runs compares what came before.`;
  }
  if (run.state === 'partial') return `Its record is incomplete: ${pretty(run.reason)}.`;
  if (run.duration < SHORTEST) {
    return `Too short: ${durationText(run.duration)} recorded, a judgement takes ${SHORTEST} s.`;
  }
  return '';
}

/**
 * How both are compared: from where the metrics of the simulation begin. Drives come to the start
 * with friction that already holds them, a simulation does not.
 */
export function howJudged({ result }: Pick<RunDetail, 'result'>): How {
  const { window } = result as { window?: { start: number } | null };
  return window ? { ...USUAL, start: window.start } : USUAL;
}

/** The reference of each axis, whose ranges tell which axes move. */
export const REFERENCES = AXES.map((axis) => `${axis}.position_reference`);

/** Following errors of the axes that move, of a comparison of `REFERENCES` and one that is judged. */
export function movingErrors(
  references: Pick<Comparison, 'channels'>,
  judged: Pick<Comparison, 'channels'>,
): ChannelComparison[] {
  const moving = AXES.filter((axis, i) => {
    const reference = references.channels.find(({ name }) => name === REFERENCES[i]);
    return (reference?.range ?? Number.POSITIVE_INFINITY) > AT_REST;
  });
  return judged.channels.filter(
    ({ name, at }) =>
      at !== null && moving.some((axis) => name.endsWith(`.${axis}.following_error`)),
  );
}
