/** What-if: the scenario simulated anew while a control moves; the newest question wins. */

import type { Range, SampleSource, StillSource } from '../../plot/source';
import { ApiError, type Api } from '../api/client';
import type { Changes, ProblemField, Scenario } from '../api/types';
import { errorText } from '../error-text';
import { LatestWins } from '../latest-wins';
import { lineRate } from '../line-rate';
import { within, SeenCurves } from '../runs/seen-curves';
import { Backoff } from '../stream/stream-client';
import { type Preview, readAnswer } from '../api/curves-answer';
import type { PageKernel } from './page-kernel';
import { Refused } from './refused-changes';

/** Bins of each curve while a control moves: more than a scope has pixels, and no more to carry. */
const COARSE = 1000;
/** Bins of the final curves: every tick of a run of 10 s, for zooming. */
const FINE = 20_000;
const FINE_LEAST = 4000;
/** Bins of an answer that has every sample: 250 s of them. */
const EVERY = 500_000;
/** Most numbers of an answer that curves are worth, over all of them. */
const NUMBERS = 1e6;
/** Time that the curves of an answer may take on the line, s, and bins that they have anyway. */
const CARRIED = 2;
const CARRIED_LEAST = 250;
/** A newer question ends one that has taken so long, ms: on a slow line an answer takes its time. */
const GIVEN_UP = 1000;
/** So long after the last question it counts as the last, ms. */
const REST = 200;
const TIMEOUT = 60_000;
/** Wait before a request to a busy or unreachable server is repeated, ms. */
const AGAIN = { first: 250, longest: 4000 };
/** A part is read with so much of its length on both sides. */
const MARGIN = 0.5;

export interface Question {
  scenario: Scenario;
  set: Changes;
  columns: string[];
}

/** `preview` while a control moves, `whole` once it rests, `part` for looking closer at some of that. */
interface Job {
  question: Question;
  /** Of later questions it is higher. */
  turn: number;
  what: 'preview' | 'whole' | 'part';
  range: Range | null;
}

export interface Answered extends Preview {
  question: Question;
}

/**
 * `waiting`: nothing yet. `preview`: the curves precede the last change, or a control still moves.
 * `exact`: the curves are the result of the controls. `retrying`: the server is busy or out of
 * reach, and the last request is repeated; the curves are older. `failed`: the last request was
 * refused; the curves are older.
 */
export type WhatIfStatus = 'waiting' | 'preview' | 'exact' | 'retrying' | 'failed';

export class WhatIf {
  answer = $state.raw<Answered | null>(null);
  /** The newest answer with the whole run. */
  whole = $state.raw<Answered | null>(null);
  standing = $state<WhatIfStatus>('waiting');
  /** ms from question to preview, for the newest, and where it was computed. */
  took = $state(0);
  computer = $state<'page' | 'server'>('server');
  /** Why the server computes what the page might; empty where the page does. */
  obstacle = $state('');
  /** Why the last request was refused, or is repeated. */
  reason = $state('');
  /** What has come of the newest question's run from its start: the whole, and finer curves of parts. */
  private seen = $state.raw(new SeenCurves());
  /** Counts what has come, for those who look at `seen`. */
  private readings = $state(0);
  /** What is looked at. */
  private range: Range | null = null;
  /** The newest question, and that of the answer. */
  private turn = 0;
  private shown = 0;
  private readonly queue = new LatestWins<Job>((job) => this.run(job));
  /** Previews of the page. */
  private readonly own = new LatestWins<Job>((job) => this.preview(job));
  private rest: ReturnType<typeof setTimeout> | null = null;
  private again: ReturnType<typeof setTimeout> | null = null;
  private readonly backoff = new Backoff(AGAIN.first, AGAIN.longest);

  /** The request under way, and since when, ms. */
  private asking: { begin: number; abort: AbortController } | null = null;

  constructor(
    private readonly api: Api,
    private readonly refused: (fields: ProblemField[], detail: string) => void,
    private readonly kernel: PageKernel | null = null,
    /** Whether the page computes everything. */
    private readonly alone = false,
  ) {}

  /** What the time axis covers by itself: the window of the metrics, or all where a schedule changes something. */
  get home(): Range | null {
    const { answer } = this;
    if (!answer) return null;
    const { start, end } = answer.result.window;
    const planned = answer.question.scenario.schedule.length > 0;
    // A page alone has no more of a long run than its end.
    const all = planned && (!this.alone || answer.how === 'whole');
    return all ? { from: 0, to: answer.duration } : { from: start, to: end };
  }

  get extent(): Range | null {
    return this.answer && { from: 0, to: this.answer.duration };
  }

  /** The curves to draw a stretch of time from; of the newest question only. */
  over(range: Range): SampleSource | null {
    void this.readings;
    const { answer, whole } = this;
    if (!answer) return null;
    if (whole?.question !== answer.question) return answer.source;
    return this.seen.best(answer.question.columns, range, fineOf(range, whole)) ?? whole.source;
  }

  /** Asks for curves soon, and for exact ones once the questions stop. `zoom` is the part looked at. */
  ask(question: Question, zoom: Range | null = null): void {
    this.standing = 'preview';
    this.range = zoom;
    const turn = ++this.turn;
    if (this.rest !== null) clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.rest = null;
      this.push({ question, turn, what: 'whole', range: null });
    }, REST);
    const preview: Job = { question, turn, what: 'preview', range: zoom };
    if (this.kernel && !this.alone) this.own.push(preview);
    else this.push(preview);
  }

  /** Looks at another stretch of time: closer curves come where the whole is too coarse for it. */
  look(range: Range): void {
    this.range = range;
    const { whole, answer, turn } = this;
    if (this.standing === 'preview' && answer) void this.lookCloser(answer, range);
    if (this.standing !== 'exact' || !whole || whole.question !== answer?.question) return;
    const { from, to } = within(range, whole) ?? range;
    if (this.seen.has(whole.question.columns, { from, to }, fineOf(range, whole))) return;
    const more = MARGIN * (to - from);
    const wider = { from: Math.max(0, from - more), to: Math.min(whole.duration, to + more) };
    this.push({ question: whole.question, turn, what: 'part', range: wider });
  }

  /** Every sample of a stretch of the newest question's run. */
  async samples(columns: readonly string[], range: Range): Promise<StillSource | null> {
    const { answer } = this;
    if (!answer) return null;
    if (this.standing === 'preview' || this.alone) {
      const own = await this.kernel?.curves(answer.question, columns, range, EVERY);
      if (own) return own;
    }
    const { scenario, set } = answer.question;
    const request = { scenario, set, columns: [...columns], ...stretchOf(range) };
    const signal = AbortSignal.timeout(TIMEOUT);
    const buffer = await this.api.whatif({ ...request, points: EVERY, exact: true }, signal);
    return readAnswer(buffer).source;
  }

  private keep({ question, source }: Answered): void {
    this.seen.put(question.columns, source);
    this.readings += 1;
  }

  /** Queues a job, in place of one that waits for its repetition. */
  private push(job: Job): void {
    if (this.again !== null) clearTimeout(this.again);
    this.again = null;
    (this.alone ? this.own : this.queue).push(job);
    const { asking } = this;
    if (asking && performance.now() - asking.begin > GIVEN_UP) asking.abort.abort();
  }

  /** Has the page compute; the server does where the page cannot. */
  private async preview(job: Job): Promise<void> {
    const { question, turn, range } = job;
    const begin = performance.now();
    try {
      const signal = AbortSignal.timeout(TIMEOUT);
      if (job.what === 'part') return await this.part(question, range);
      const [stretch, points] = this.detailOf(job);
      const preview = await this.kernel?.run(this.api, question, stretch, points, signal);
      if (!preview) return;
      if (this.alone ? turn < this.shown : turn <= this.shown) return; // a later one was faster
      const answer = { ...preview, question };
      this.show(answer, turn);
      if (job.what === 'whole') this.settle(answer);
      else this.took = performance.now() - begin;
      this.computer = 'page';
      this.obstacle = '';
      this.refused([], '');
    } catch (error) {
      const newer = this.own.superseded || turn < this.turn;
      if (this.alone || (error instanceof ApiError && !error.transient)) {
        if (!newer) this.fail(error);
        return;
      }
      // Whatever else it is, the server may still answer.
      this.obstacle = errorText(error);
      // Where the hand rests already, the exact result is on its way.
      if (!newer && this.rest !== null) this.push(job);
    }
  }

  /** Draws a preview's curves again from the samples that the page has. */
  private async lookCloser(answer: Answered, range: Range): Promise<void> {
    const { question } = answer;
    const source = await this.kernel?.curves(question, question.columns, range, COARSE);
    if (source && this.answer === answer) this.answer = { ...answer, source };
  }

  /** What to compute of a job: the stretch of time, and how finely. */
  private detailOf({ question, what, range }: Job): [range: Range | null, points: number] {
    if (what === 'preview') return [range, COARSE];
    const numbers = 2 * question.columns.length;
    const most = Math.max(FINE_LEAST, Math.floor(NUMBERS / numbers));
    const carried = Math.max(CARRIED_LEAST, Math.floor((CARRIED * lineRate()) / (4 * numbers)));
    return [what === 'whole' ? { from: 0, to: LATEST } : range, Math.min(FINE, most, carried)];
  }

  /** Reads finer curves of a part in the page. */
  private async part(question: Question, range: Range | null): Promise<void> {
    const { whole } = this;
    if (!range || whole?.question !== question) return;
    const source = await this.kernel?.curves(question, question.columns, range, FINE);
    if (source && whole === this.whole) this.keep({ ...whole, source });
  }

  /** Takes the result of a question's whole run, unless another question has come. */
  private settle(answer: Answered): void {
    this.whole = answer;
    this.seen = new SeenCurves();
    this.keep(answer);
    // Too long a scenario never runs from its start: its preview is final.
    if (this.rest === null && !(this.alone ? this.own : this.queue).superseded) {
      this.standing = 'exact';
      if (this.range) this.look(this.range);
    }
  }

  private show(answer: Answered, turn: number): void {
    this.answer = answer;
    this.shown = turn;
  }

  private async run(job: Job): Promise<void> {
    const { question, turn, what } = job;
    const begin = performance.now();
    const abort = new AbortController();
    this.asking = { begin, abort };
    try {
      const signal = AbortSignal.any([AbortSignal.timeout(TIMEOUT), abort.signal]);
      const [from, points] = this.detailOf(job);
      const stretch = stretchOf(from);
      const exact = what !== 'preview';
      const buffer = await this.api.whatif({ ...question, ...stretch, points, exact }, signal);
      const answer = { ...readAnswer(buffer), question };
      const known = question === this.whole?.question;
      if (what === 'part') return known ? this.keep(answer) : undefined;
      if (turn < this.shown) return; // the page has shown a later one
      this.show(answer, turn);
      if (exact) this.settle(answer);
      else {
        this.took = performance.now() - begin;
        this.computer = 'server';
      }
      this.backoff.reset();
      this.refused([], '');
    } catch (error) {
      // A newer question is on its way; its answer counts.
      if (this.queue.superseded || turn < this.turn) return;
      if (error instanceof ApiError && error.transient) {
        this.standing = what === 'part' ? this.standing : 'retrying';
        this.reason = error.message;
        const wait = this.backoff.next();
        this.again = setTimeout(() => this.push(job), error.retryAfter ?? wait);
        return;
      }
      if (what !== 'part') this.fail(error);
    } finally {
      this.asking = null;
    }
  }

  /** Says why the newest question was refused; the curves are those before it. */
  private fail(error: unknown): void {
    this.standing = 'failed';
    this.reason = errorText(error);
    this.refused(error instanceof ApiError ? error.problem.errors : [], this.reason);
    // The server is asked about what the page alone refuses.
    if (this.rest === null || error instanceof Refused) return;
    clearTimeout(this.rest);
    this.rest = null;
  }
}

/** Later than any scenario ends, s. */
const LATEST = 1e6;

/** The largest bin with which a stretch of time is drawn as finely as there are pixels, s. */
function fineOf({ from, to }: Range, { period }: Preview): number {
  return Math.max(1.5 * period, (to - from) / COARSE);
}

function stretchOf(range: Range | null): { start?: number; end?: number } {
  return range ? { start: range.from, end: range.to } : {};
}
