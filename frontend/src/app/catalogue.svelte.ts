/** Shipped scenarios and parts of scenarios, with motors of one's own. */

import type { Api } from './api/client';
import type { Parts, Scenario, ScenarioEntry, StudyKind, Value } from './api/types';
import { served } from './fields/fields.svelte';

export class Catalogue {
  scenarios = $state.raw<readonly ScenarioEntry[]>([]);
  parts = $state.raw<Parts>({ motors: [], controllers: [], trajectories: [] });
  /** The shipped scenario of the session's name, with the paper's values. */
  shipped = $state.raw<Scenario | null>(null);
  /** What shipped parts consist of, as `path=name`. */
  resolved = $state.raw<Readonly<Record<string, Value>>>({});

  constructor(private readonly api: Api) {}

  async load(): Promise<void> {
    [served.scenario, this.scenarios, this.parts] = await Promise.all([
      this.api.fields(),
      this.api.scenarios(),
      this.api.parts(),
    ]);
  }

  /** Loads the fields of studies' requests, unless they are there. */
  async loadRequests(kinds: readonly StudyKind[]): Promise<void> {
    const unknown = kinds.filter((kind) => !(kind in served.requests));
    if (unknown.length > 0) await this.renewRequests(unknown);
  }

  /** Loads again what laws declare. */
  async lawsChanged(scenario: string): Promise<void> {
    served.scenario = await this.api.fields();
    await this.renewRequests(Object.keys(served.requests) as StudyKind[]);
    await this.loadShipped(scenario);
  }

  private async renewRequests(kinds: readonly StudyKind[]): Promise<void> {
    const load = async (kind: StudyKind) => [kind, await this.api.requestFields(kind)] as const;
    const requests = Object.fromEntries(await Promise.all(kinds.map(load)));
    served.requests = { ...served.requests, ...requests };
  }

  async loadShipped(name: string): Promise<void> {
    const known = this.scenarios.some((entry) => entry.name === name);
    this.shipped = known ? await this.api.scenario(name) : null;
  }

  /** Loads the parts again, once a motor of one's own was saved or deleted. */
  async motorChanged(name: string): Promise<void> {
    const others = Object.entries(this.resolved).filter(([key]) => key !== `plant=${name}`);
    this.resolved = Object.fromEntries(others);
    this.parts = await this.api.parts();
  }

  /** Looks up what a motor consists of, so that the controls can show it. */
  async resolvePlant(name: string): Promise<void> {
    const key = `plant=${name}`;
    if (key in this.resolved) return;
    const { plant } = await this.api.parse(`base = "circle"\nplant = "${name}"\n`);
    this.resolved = { ...this.resolved, [key]: plant };
  }
}
