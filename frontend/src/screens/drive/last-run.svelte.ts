/** The latest run on drives in the library, held against its simulation. */

import type { ChannelComparison, Comparison, RunDetail } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import { LatestWins } from '../../app/latest-wins';
import { bodyOf, type How } from '../../parts/compare/compare-request';
import { compareRuns, getRun, listRuns } from '../../parts/runs/runs-api';
import { simulateRun, simulationOf } from '../../parts/runs/simulate-run';
import { howJudged, movingErrors, REFERENCES, whyNotJudged } from './last-run';

interface Judgement {
  /** Its simulation, and itself. */
  pair: readonly [string, string];
  how: How;
  answer: Comparison;
  /** Following errors of the axes that move. */
  errors: readonly ChannelComparison[];
}

class LastRun {
  run = $state.raw<RunDetail | null>(null);
  judgement = $state.raw<Judgement | null>(null);
  /** Whether it is simulated or compared at the moment. */
  busy = $state(false);
  problem = $state('');
  readonly why = $derived(this.run ? whyNotJudged(this.run) : '');
  private readonly questions = new LatestWins<null>(() => this.read());

  /** Looks whether there is another run, or more of this one. */
  look(): void {
    this.questions.push(null);
  }

  /** Simulates the run, and compares both. */
  async simulate(): Promise<void> {
    const { run } = this;
    if (!run || this.busy) return;
    this.busy = true;
    const simulation = await simulateRun(run);
    try {
      const judgement = simulation === null ? null : await judge(run.id, simulation);
      if (this.run === run) [this.judgement, this.problem] = [judgement, ''];
    } catch (error) {
      this.problem = errorText(error);
    }
    this.busy = false;
  }

  private async read(): Promise<void> {
    try {
      const [run] = (await listRuns({ q: 'kind:drive', sort: '-created', limit: 1 })).runs;
      this.problem = '';
      if (run?.id === this.run?.id && run?.state === this.run?.state) return;
      this.judgement = null;
      this.run = run ? await getRun(run.id) : null;
      if (!this.run || this.why !== '') return;
      this.busy = true;
      const simulation = await simulationOf(this.run.id);
      if (simulation !== null) this.judgement = await judge(this.run.id, simulation);
    } catch (error) {
      this.problem = errorText(error);
    }
    this.busy = false;
  }
}

async function judge(run: string, simulation: string): Promise<Judgement> {
  const [a, b, how] = [simulation, run, howJudged(await getRun(simulation))];
  const [answer, references] = await Promise.all([
    compareRuns({ a, b, ...bodyOf(how) }),
    compareRuns({ a, b, ...bodyOf({ ...how, only: REFERENCES }) }),
  ]);
  return { pair: [a, b], how, answer, errors: movingErrors(references, answer) };
}

export const lastRun = new LastRun();
