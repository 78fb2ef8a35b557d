/** Runs of one variant with changes, several at once: what an explained peak is made of. */

import { Crew } from '../../kernel/crew';
import type { Axis, Lanes } from '../../kernel/lanes';
import { AXES } from '../../kernel/module';
import type { Request, RunResult } from '../../kernel/tasks';
import { withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Why } from '../api/types';
import { Beyond, changedLanes, inEffect, type LaneCode } from '../whatif/changed-lanes';
import { Refused } from '../whatif/refused-changes';
import { binsOf, runOf } from '../whatif/run-request';
import { planMotion } from './motion';
import type { MotionCode } from './motion-code';
import { explain, type WhyData, type WhyRequest } from './why';

const ALL = { from: 0, to: 1e6 };
const EVERY = 1e9;

/**
 * Explains a peak in workers of its own, which end with it.
 *
 * @param lanes of the scenario
 * @throws Refused, Beyond
 */
export async function whyDocument(
  data: WhyData,
  request: WhyRequest,
  [code, lanes, scenario]: readonly [LaneCode, Lanes, Scenario],
  motions: MotionCode,
): Promise<Why> {
  if (lanes.epochs.length > 1) throw new Beyond('the schedule changes the run');
  // Changes hold throughout, whatever is scheduled.
  const now = { ...inEffect(scenario, lanes.epochs[0] ?? 0, lanes.period), schedule: [] };
  const [window] = lanes.windows;
  const lap = planMotion(motions, scenario.trajectory).period * lanes.period || null;
  const crew = await Crew.open().catch(beyond);
  const errors = (cases: readonly Changes[]) =>
    errorsWith(crew, code, lanes, now, request.variant, cases);
  try {
    return await explain(data, request, {
      ...lanes,
      scenario: now,
      window: window as { start: number; end: number },
      lap,
      errors,
    });
  } finally {
    crew.end();
  }
}

async function errorsWith(
  crew: Crew,
  code: LaneCode,
  lanes: Lanes,
  scenario: Scenario,
  variant: string,
  cases: readonly Changes[],
): Promise<(Record<Axis, Float32Array> | string)[]> {
  const index = Object.keys(scenario.variants).indexOf(variant);
  const places = AXES.map((axis) => ({
    name: '',
    channel: 'following_error',
    axis,
    variant: index,
  }));
  const bins = binsOf(lanes, ALL, EVERY);
  const requests = cases.map((set): Request | string => {
    try {
      const changed = changedLanes(code, lanes, scenario, withChanges(scenario, set));
      const run = runOf(changed, variant, index, places, bins);
      return { kind: 'run', run: { ...run, windows: [], linear: false } };
    } catch (error) {
      if (error instanceof Beyond || error instanceof Refused) return error.message;
      throw error;
    }
  });
  const { keys, inputs: numbers, tables, ...rest } = lanes;
  const key = `${keys.inputs} ${keys.tables}`;
  const inputs = { ...rest, key, numbers: numbers as Float64Array, tables: tables as Float64Array };
  const runs = requests.filter((each) => typeof each !== 'string');
  const results = (await crew.each<RunResult>(inputs, runs).catch(beyond)) as RunResult[];
  let next = 0;
  return requests.map((each) => {
    if (typeof each === 'string') return each;
    const curves = results[next++]?.curves ?? [];
    return Object.fromEntries(AXES.map((axis, i) => [axis, curves[i]?.minimum])) as Record<
      Axis,
      Float32Array
    >;
  });
}

function beyond(error: unknown): never {
  throw new Beyond(error instanceof Error ? error.message : String(error));
}
