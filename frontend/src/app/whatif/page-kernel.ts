/** The kernel in the page: a what-if that it computes, where it can. */

import { Crew, WorkerEnded } from '../../kernel/crew';
import { type Lanes, readLanes } from '../../kernel/lanes';
import { resultOf } from '../../kernel/result';
import type { Curve, Inputs, Request, Run, RunResult } from '../../kernel/tasks';
import { isMath, type Range, type StillSource } from '../../plot/source';
import type { Api } from '../api/client';
import type { Preview } from '../api/curves-answer';
import { equal } from '../api/scenario-paths';
import type { Metrics } from '../api/types';
import { type Known, LaneChanges, type Numbers } from './lane-changes';
import { Loading, PATIENCE } from './loading';
import { binsOf, ofVariant, placesOf, runOf, sameRun, sourceOf } from './run-request';
import type { Question } from './whatif.svelte';

/** So long the server is not asked again for what it said that the page cannot run, ms. */
const AGAIN = 5000;

/** What the page cannot run, and why: the server does. */
export class Obstacle extends Error {}

/** Whether a column is of the state of a law of one's own. */
const ofOwnLaw = (column: string) => /^[A-Z]\.[xy]\.law_/.test(column);

/** A question that the server answered with an obstacle, and when. */
interface OnlyServer {
  question: Question;
  range: Range | null;
  obstacle: string;
  time: number;
}

/** The latest run, whose samples the workers have. */
interface Latest {
  question: Question;
  inputs: Inputs;
  runs: readonly { run: Run; result: RunResult }[];
}

export class PageKernel {
  private crew: Loading<Crew> | null = null;
  /** Whether the crew is in place of one that ended, and has not answered yet. */
  private second = false;
  private inputs: Known | null = null;
  private latest: Latest | null = null;
  private onlyServer: OnlyServer | null = null;
  /** Ends with the last run or reading: one at a time, as the workers have one run's samples. */
  private last: Promise<unknown> = Promise.resolve();

  /**
   * @param changes makes lanes without the server, where it can
   * @param patience so long the workers are waited for, ms; then the server computes until they are there
   */
  constructor(
    private readonly changes = new LaneChanges(),
    private readonly open = Crew.open,
    private readonly patience = PATIENCE,
  ) {}

  /**
   * Runs a question; curves of a stretch of time, or of the window, in so many bins at most.
   *
   * @throws Obstacle where the server has to run it, Refused where it will refuse it, ApiError where it has
   */
  run(
    api: Pick<Api, 'whatifLanes'>,
    question: Question,
    range: Range | null,
    points: number,
    signal: AbortSignal,
  ): Promise<Preview> {
    return this.inTurn(() => this.preview(api, question, range, points, signal));
  }

  private async preview(
    api: Pick<Api, 'whatifLanes'>,
    question: Question,
    range: Range | null,
    points: number,
    signal: AbortSignal,
  ): Promise<Preview> {
    const crew = await this.crewOf();
    if (question.columns.some(isMath)) throw new Obstacle('math channels are computed there');
    if (question.columns.some(ofOwnLaw)) throw new Obstacle("states of one's own laws are there");
    const changed = await this.changes.lanesOf(question, range);
    const { lanes, inputs } = changed ?? (await this.check(api, crew, question, range, signal));
    const variants = Object.keys(lanes.windows[0]?.variants ?? {});
    const places = placesOf(question.columns, variants);
    const bins = binsOf(lanes, range, points);
    const runs = variants.map((name, i) => runOf(lanes, name, i, places, bins));
    const results = await this.runs(crew, inputs, runs);
    this.latest = {
      question,
      inputs,
      runs: runs.map((run, i) => ({ run, result: results[i] as RunResult })),
    };
    const { how, first, ticks, period } = lanes;
    const curves = results.map((each) => each.curves);
    const loops = results.flatMap((each, i) =>
      each.loops ? [[variants[i] as string, each.loops] as const] : [],
    );
    return {
      loops: loops.length === results.length ? Object.fromEntries(loops) : null,
      result: resultOf(lanes, results) as unknown as Metrics,
      how,
      begin: first * period,
      duration: ticks * period,
      period,
      source: sourceOf(places, curves, bins, period),
    };
  }

  /** Has the server check a question, and takes the inputs that are new. */
  private async check(
    api: Pick<Api, 'whatifLanes'>,
    crew: Crew,
    question: Question,
    range: Range | null,
    signal: AbortSignal,
  ): Promise<Numbers> {
    const { scenario, set } = question;
    if (this.onlyServer && resembles(this.onlyServer, question, range)) {
      throw new Obstacle(this.onlyServer.obstacle);
    }
    const stretch = range ? { start: range.from, end: range.to } : {};
    const known = this.inputs?.keys ?? { inputs: '', tables: '' };
    const buffer = await api.whatifLanes({ scenario, set, ...stretch, ...known }, signal);
    const lanes = readLanes(buffer);
    if ('obstacle' in lanes) {
      this.onlyServer = { question, range, obstacle: lanes.obstacle, time: performance.now() };
      throw new Obstacle(lanes.obstacle);
    }
    if (lanes.module !== crew.about.module) {
      // It stays so until the page is loaded anew.
      const obstacle = new Obstacle('this page has the kernel of another version');
      this.latest = null;
      crew.end();
      this.crew = new Loading(() => Promise.reject(obstacle), this.patience);
      await this.crew.value;
    }
    const inputs = (this.inputs = this.inputsOf(lanes));
    const numbers = { lanes: { ...lanes, inputs: null, tables: null }, inputs };
    this.changes.take(question, numbers);
    return numbers;
  }

  /** Reads every sample of a stretch, in bins, of a question that was the last to run; else null. */
  curves(
    question: Question,
    columns: readonly string[],
    range: Range,
    points: number,
  ): Promise<StillSource | null> {
    return this.inTurn(() => this.reading(question, columns, range, points));
  }

  private async reading(
    question: Question,
    columns: readonly string[],
    range: Range,
    points: number,
  ): Promise<StillSource | null> {
    const { latest, crew } = this;
    if (!crew || latest?.question !== question || columns.some(isMath)) return null;
    const { inputs, runs } = latest;
    const variants = runs.map(({ run }) => run.variant);
    const places = placesOf(columns, variants);
    const bins = binsOf({ ...inputs, windows: [] }, range, points);
    const requests = variants.map((variant, i): Request => {
      return { kind: 'curves', variant, columns: ofVariant(places, i), bins };
    });
    const curves = (await this.all<Curve[]>(await crew.value, inputs, requests)) as Curve[][];
    return sourceOf(places, curves, bins, inputs.period);
  }

  /** Runs variants; one that a change leaves alone keeps its run. */
  private async runs(crew: Crew, inputs: Inputs, runs: readonly Run[]): Promise<RunResult[]> {
    const before = runs.map((run, i) => {
      const last = this.latest?.inputs === inputs ? this.latest.runs[i] : undefined;
      return last && sameRun(last.run, run) ? last.result : null;
    });
    const requests = runs.map((run, i): Request | null =>
      before[i] ? null : { kind: 'run', run },
    );
    this.latest = null;
    const results = await this.all<RunResult>(crew, inputs, requests);
    return results.map((result, i) => (result ?? before[i]) as RunResult);
  }

  private async all<T extends RunResult | Curve[]>(
    crew: Crew,
    inputs: Inputs,
    requests: readonly (Request | null)[],
  ): Promise<(T | null)[]> {
    try {
      const answers = await crew.each<T>(inputs, requests);
      this.second = false;
      return answers;
    } catch (error) {
      this.latest = null;
      if (error instanceof WorkerEnded) {
        crew.end();
        if (!this.second) this.crew = null;
        this.second = true;
      }
      throw new Obstacle(error instanceof Error ? error.message : String(error));
    }
  }

  /** Opens the workers before there is a question for them. */
  warm(): void {
    this.crewOf().catch(() => undefined); // the first question says why
  }

  private inTurn<T>(job: () => Promise<T>): Promise<T> {
    const result = this.last.then(job);
    this.last = result.catch(() => undefined);
    return result;
  }

  private async crewOf(): Promise<Crew> {
    let crew: Crew | null;
    try {
      this.crew ??= new Loading(this.open, this.patience);
      crew = await this.crew.soon();
    } catch (error) {
      throw new Obstacle(error instanceof Error ? error.message : String(error));
    }
    if (!crew) throw new Obstacle('the kernel of the page is still loading');
    return crew;
  }

  /** The inputs of an answer, or those that are known. */
  private inputsOf({ keys, rows, references, first, stop, period, ...numbers }: Lanes): Known {
    const before = this.inputs;
    const same = before?.keys.inputs === keys.inputs ? before : null;
    const inputs = numbers.inputs ?? same?.numbers;
    const tables = numbers.tables ?? (before?.keys.tables === keys.tables ? before.tables : null);
    if (!inputs || !tables) throw new Obstacle('the inputs are missing');
    if (same && before?.keys.tables === keys.tables) return same;
    const shared = same ?? { rows, references, first, stop, period };
    return { ...shared, keys, key: `${keys.inputs} ${keys.tables}`, numbers: inputs, tables };
  }
}

/** Whether a question has the same changed fields as one beyond the page a moment ago. */
function resembles({ question, range, time }: OnlyServer, other: Question, stretch: Range | null) {
  if (performance.now() - time > AGAIN) return false;
  const paths = ({ set }: Question) => Object.keys(set).sort();
  return (
    question.scenario === other.scenario &&
    equal(paths(question), paths(other)) &&
    equal(range, stretch)
  );
}
