/** What the server ships: scenarios, and parts of scenarios. */

import type { Api } from './api/client';
import type { Parts, Scenario, ScenarioEntry, Value } from './api/types';

export class Catalogue {
  scenarios = $state.raw<readonly ScenarioEntry[]>([]);
  parts = $state.raw<Parts>({ motors: [], controllers: [], trajectories: [] });
  /** The shipped scenario of the session's name, where the paper's values stand. */
  shipped = $state.raw<Scenario | null>(null);
  /** What shipped parts consist of, as `path=name`. */
  resolved = $state.raw<Readonly<Record<string, Value>>>({});

  constructor(private readonly api: Api) {}

  async load(): Promise<void> {
    [this.scenarios, this.parts] = await Promise.all([this.api.scenarios(), this.api.parts()]);
  }

  async loadShipped(name: string): Promise<void> {
    const known = this.scenarios.some((entry) => entry.name === name);
    this.shipped = known ? await this.api.scenario(name) : null;
  }

  /** Looks up what a shipped motor consists of, so that the controls can show it. */
  async resolvePlant(name: string): Promise<void> {
    const key = `plant=${name}`;
    if (key in this.resolved) return;
    const { plant } = await this.api.parse(`base = "circle"\nplant = "${name}"\n`);
    this.resolved = { ...this.resolved, [key]: plant };
  }
}
