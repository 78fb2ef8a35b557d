/** Lanes of a question from those of one that the server has checked: no slider waits for the server. */

import type { Lanes } from '../../kernel/lanes';
import type { Inputs } from '../../kernel/tasks';
import type { Range } from '../../plot/source';
import { at, equal, isTable, withChanges } from '../api/scenario-paths';
import type { Changes, Scenario, Value } from '../api/types';
import { needsRestart } from '../fields/fields.svelte';
import { Beyond, changedLanes, type LaneCode } from './changed-lanes';
import { Loading, PATIENCE } from './loading';
import type { Question } from './whatif.svelte';

/** Inputs by the keys that the server knows them by. */
export interface Known extends Inputs {
  keys: Lanes['keys'];
}

/** What a question runs with. */
export interface Numbers {
  lanes: Lanes;
  inputs: Known;
}

export class LaneChanges {
  private code: Loading<LaneCode | null> | null = null;
  /** The latest question that the server has checked; its scenario has the changes, and is null where they name a part that is not known. */
  private checked: (Numbers & { from: Scenario; scenario: Scenario | null }) | null = null;

  /** @param parts what parts of scenarios consist of, as `path=name` */
  constructor(
    private readonly parts: () => Readonly<Record<string, Value>> = () => ({}),
    private readonly load: () => Promise<LaneCode> = () => import('../../../lanes.js'),
  ) {}

  /** Takes the server's numbers of a question. */
  take({ scenario, set }: Question, numbers: Numbers): void {
    this.checked = { ...numbers, from: scenario, scenario: this.changed(scenario, set) };
  }

  /**
   * Returns the numbers of a question; null where the server has to make them.
   *
   * @throws Refused
   */
  async lanesOf({ scenario, set }: Question, range: Range | null): Promise<Numbers | null> {
    const { checked } = this;
    if (!checked || !reaches(checked.lanes, range, set)) return null;
    if (checked.from !== scenario) {
      if (!equal(checked.from, scenario)) return null;
      checked.from = scenario; // read anew, and the same
    }
    const changed = this.changed(scenario, set);
    this.code ??= new Loading(() => this.load().catch(() => null), PATIENCE);
    const code = await this.code.soon();
    if (!code || !checked.scenario || !changed) return null;
    const { lanes, inputs } = checked;
    try {
      return { lanes: changedLanes(code, lanes, checked.scenario, changed), inputs };
    } catch (error) {
      if (error instanceof Beyond) return null;
      throw error;
    }
  }

  private changed(scenario: Scenario, set: Changes): Scenario | null {
    const parts = this.parts();
    const known = Object.entries(set).every(
      ([path, value]) =>
        typeof value !== 'string' || !isTable(at(scenario, path)) || `${path}=${value}` in parts,
    );
    return known ? withChanges(scenario, set, parts) : null;
  }
}

/** Whether a run goes over a stretch of time as far as the scenario does, and takes the changes. */
function reaches({ how, first, stop, period }: Lanes, range: Range | null, set: Changes): boolean {
  if (how === 'whole') return true;
  // A stored state holds for what may change during a run.
  if (Object.keys(set).some(needsRestart)) return false;
  return !range || (first * period <= range.from && range.to <= stop * period);
}
