/** Views of the Lab that a demo computes: the page's kernel runs what they are of. */

import { Api } from '../api/client';
import { withChanges } from '../api/scenario-paths';
import { AXES, type Changes, type Scenario } from '../api/types';
import { PageKernel } from '../whatif/page-kernel';
import { circularTest, type Recorded } from './circular-test';

export { spectrumDocument } from './spectrum';

/** Later than any scenario ends, s, and more samples than it has. */
const ALL = { from: 0, to: 1e6 };
const EVERY = 1e9;
const TIMEOUT = 60_000; // ms

/** A kernel of its own: the Lab's keeps the samples that are drawn. */
const kernel = new PageKernel(undefined, undefined, Number.POSITIVE_INFINITY);
const api = new Api();

/** @throws Error, ApiError where the scenario cannot be run or has no circle */
export async function ballbar({ scenario, set = {} }: { scenario: Scenario; set?: Changes }) {
  const whole = withChanges(scenario, set);
  return circularTest(await record(scenario, set), Object.keys(whole.variants), async (way) => {
    const { trajectory } = whole;
    if (trajectory.kind !== 'circle') return "its trajectory is not kind = 'circle'";
    const turned = { ...whole, trajectory: { ...trajectory, direction: way, laps: 2 } };
    try {
      return await record({ ...turned, window: null, schedule: [] }, {});
    } catch (error) {
      return error instanceof Error ? error.message : String(error);
    }
  });
}

/** Runs a scenario and returns every tick of it. */
async function record(scenario: Scenario, set: Changes): Promise<Recorded> {
  const { plant, variants } = withChanges(scenario, set);
  const names = Object.keys(variants);
  const columns = [
    ...AXES.map((axis) => `${axis}.position_reference`),
    ...names.flatMap((name) => AXES.map((axis) => `${name}.${axis}.following_error`)),
  ];
  const question = { scenario, set, columns };
  const signal = AbortSignal.timeout(TIMEOUT);
  const { source, period } = await kernel.run(api, question, ALL, EVERY, signal);
  const [x, y, ...errors] = columns.map((name) => {
    const [low, high] = [new Float32Array(source.last), new Float32Array(source.last)];
    source.reduce(name, { first: 0, size: 1, count: source.last, paired: false }, low, high);
    return Float64Array.from(low);
  }) as [Float64Array, Float64Array, ...Float64Array[]];
  return {
    period,
    x,
    y,
    errors: Object.fromEntries(
      names.map((name, i) => [
        name,
        [errors[2 * i], errors[2 * i + 1]] as [Float64Array, Float64Array],
      ]),
    ),
    counts: [plant.x.encoder.resolution, plant.y.encoder.resolution],
  };
}
