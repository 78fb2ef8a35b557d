/** The server's routes of paths, in the page: checked, slowed down, kept in this browser. */

import { withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Trajectory, TrajectoryEntry, Value } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { NEEDS_SERVER } from './demo-mode';
import { drop, keep, listed, pathOf } from './kept-paths';
import type { MotionCode } from './motion-code';
import { checkRanges, type MotionRanges } from './motion-limits';
import { checkPath, packed } from './path-check';
import { json, problem, refusal } from './responses';
import { slowDown } from './slower';

interface PathRequest {
  scenario: Scenario;
  set?: Changes;
  trajectory: Scenario['trajectory'];
  points?: number;
}

/** Answers a request about paths; `shipped` are those in the folder. */
export function answerOfPaths(
  code: MotionCode,
  [method, path, body]: readonly [method: string, path: string, body: string],
  shipped: readonly TrajectoryEntry[],
  parts: Record<string, Value>,
  ranges: MotionRanges,
): Response {
  try {
    if (path === '/trajectories') return json(listed(shipped));
    if (path === '/trajectories/check' || path === '/trajectories/slow') {
      const { scenario, set = {}, trajectory, points = 600 } = JSON.parse(body) as PathRequest;
      const { plant, schedule } = withChanges(scenario, set, parts);
      if (schedule.length > 0) throw new Beyond('A schedule has the times of its own motion');
      checkRanges(trajectory, ranges);
      if (path.endsWith('slow')) return json(slowDown(code, trajectory, plant));
      return new Response(packed(checkPath(code, trajectory, plant, points)));
    }
  } catch (error) {
    return refusal(error);
  }
  const [, name] = /^\/trajectories\/([a-z0-9-]+)$/.exec(path) ?? [];
  if (name === undefined || name === 'import' || name === 'export') {
    return problem(501, NEEDS_SERVER);
  }
  return ofName(method, name, body);
}

function ofName(method: string, name: string, body: string): Response {
  if (method === 'DELETE') {
    drop(name);
    return new Response(null, { status: 204 });
  }
  const kept = method === 'PUT' ? keep(name, JSON.parse(body) as Trajectory) : pathOf(name);
  const lost =
    method === 'PUT' ? 'This browser does not keep it.' : `This browser has no path ${name}.`;
  return kept ? json(kept) : problem(404, lost);
}
