/** What a view is of: the Lab's what-if, its session, or a run; its channels and samples. */

import { readAnswer } from '../../app/api/curves-answer';
import type { RunDetail, Scenario } from '../../app/api/types';
import { withChanges } from '../../app/api/scenario-paths';
import { errorText } from '../../app/error-text';
import { samplesOf as ticksOf } from '../../app/runs/run-range';
import { app } from '../../app/store.svelte';
import { unitsOf } from '../../plot/scope-catalog';
import type { Channel, Range, SampleSource } from '../../plot/source';
import { getRun, runSpectrum } from '../runs/runs-api';
import { RunSource } from '../runs/run-source.svelte';
import type { SpectrumDocument, SpectrumSettings } from '../spectrum/spectrum-view';
import { lastOf, MOST, samplesOf, type Sampled, type Subject } from './views-api';

/** Most samples of all columns that a spectrum's request takes. */
const VALUES_MAX = 60_000;
const TIMEOUT = 60_000; // ms
const EVERY = 500_000;
const PERIOD = 0.5e-3; // s, until it is known
/** Of a session, without a stretch: the newest so long, s. */
const NEWEST = 10;

export interface ViewSource {
  /** Such as `Staged` or a run's name. */
  readonly title: string;
  readonly scenario: Scenario | null;
  /** The variants that views of two draw. */
  readonly names: readonly string[];
  readonly channels: readonly Channel[];
  /** What a view of the server is of; null while there is nothing. */
  readonly subject: Subject | null;
  /** The stretch that samples are of where none is chosen. */
  readonly home: Range | null;
  /** Another whenever samples are others. */
  readonly version: string;
  readonly period: number;
  /** Why there is nothing; empty while there is, or soon will be. */
  readonly problem: string;
  samples(columns: readonly string[], range: Range): Promise<Sampled>;
  spectrum(
    columns: readonly string[],
    range: Range,
    settings: SpectrumSettings,
  ): Promise<SpectrumDocument>;
}

const NOTHING = 'Nothing has been simulated yet.';

/** Of the Lab: `staged` its what-if, `live` its session, `lab` whichever it shows. */
export class LabSource implements ViewSource {
  /** Counts seconds, for a session that goes on. */
  private beat = $state(0);
  readonly problem = '';

  constructor(private readonly of: 'lab' | 'staged' | 'live') {}

  /** Looks every second for new samples; returns what ends that. */
  start(): () => void {
    const timer = setInterval(() => (this.beat += 1), 1000);
    return () => clearInterval(timer);
  }

  private get live(): boolean {
    return this.of === 'live' || (this.of === 'lab' && app.mode === 'live');
  }

  get title(): string {
    return this.live ? 'In the motor' : 'Staged';
  }

  readonly names = $derived(app.variants.slice(0, 2));

  get channels(): readonly Channel[] {
    return app.session.channels;
  }

  /** What was simulated last, or would be. */
  private readonly question = $derived.by(() => {
    const { info } = app.session;
    if (this.live) return info && { scenario: info.scenario, set: {} };
    if (app.mode !== 'whatif') return info && { scenario: info.scenario, set: app.draft };
    const { answer } = app.whatif;
    return answer && { scenario: answer.question.scenario, set: answer.question.set };
  });

  get subject(): Subject | null {
    return this.question;
  }

  readonly scenario = $derived(
    this.question && withChanges(this.question.scenario, this.question.set, app.catalogue.resolved),
  );

  get period(): number {
    return app.session.moments.period || (app.whatif.answer?.period ?? PERIOD);
  }

  private get ring() {
    return app.session.client?.ring ?? null;
  }

  readonly home = $derived.by((): Range | null => {
    if (!this.live) {
      const window = this.scenario?.window;
      return app.whatif.home ?? (window ? { from: window.start, to: window.end } : null);
    }
    void this.beat;
    const to = (this.ring?.end ?? 0) * this.period;
    return { from: Math.max((this.ring?.start ?? 0) * this.period, to - NEWEST), to };
  });

  readonly version = $derived.by(() => {
    if (!this.live) return JSON.stringify(this.question);
    void this.beat;
    return `live ${app.session.id} ${this.ring?.version}`;
  });

  async samples(columns: readonly string[], range: Range): Promise<Sampled> {
    const part = lastOf(range, this.period, Math.min(MOST, VALUES_MAX / columns.length));
    if (this.live) return this.streamed(columns, part);
    const source = await this.simulated(columns, part);
    if (!source) throw new Error(NOTHING);
    return samplesOf(source, columns, 0, source.last);
  }

  private async simulated(columns: readonly string[], range: Range): Promise<SampleSource | null> {
    if (app.mode === 'whatif') return app.whatif.samples(columns, range);
    const { question } = this;
    if (!question) return null;
    const stretch = { start: Math.max(0, range.from), end: range.to };
    const body = { ...question, ...stretch, columns: [...columns], points: EVERY, exact: true };
    return readAnswer(await app.api.whatif(body, AbortSignal.timeout(TIMEOUT))).source;
  }

  private streamed(columns: readonly string[], { from, to }: Range): Sampled {
    const { ring, period } = this;
    if (!ring || ring.end === ring.start) throw new Error('Nothing has run yet: press Play.');
    if (!columns.every((column) => ring.has(column)))
      throw new Error('These channels are not streamed yet.');
    const first = Math.max(ring.start, Math.round(from / period));
    const stop = Math.min(ring.end, Math.round(to / period));
    const source = {
      start: 0,
      step: period,
      reduce: (name, bins, low, high) =>
        ring.reduce(name, bins.first, bins.size, bins.count, low, high),
    } satisfies Pick<SampleSource, 'start' | 'step' | 'reduce'>;
    return samplesOf(source, columns, first, stop);
  }

  async spectrum(columns: readonly string[], range: Range, settings: SpectrumSettings) {
    const reference = referenceOf(columns);
    const about = reference !== null && (!this.live || this.ring?.has(reference));
    const samples = await this.samples(about ? [...columns, reference] : columns, range);
    const path = about ? samples.columns.at(-1)?.values : undefined;
    const units = unitsOf(this.channels);
    const body = {
      ...settings,
      ...this.question,
      velocity: path ? medianSpeed(path, samples.period) : null,
      period: samples.period,
      columns: samples.columns
        .slice(0, columns.length)
        .map((one) => ({ ...one, unit: units.get(one.name) ?? '1' })),
    };
    const document = await app.api.json('post', '/spectrum', { body });
    const before = Math.round(samples.start / samples.period);
    const placed = document.columns.map((column) => ({
      ...column,
      start: column.start + before,
      stop: column.stop + before,
    }));
    return { ...document, columns: placed };
  }
}

/** The reference of the axis whose following errors columns are; null of several axes, or of none. */
function referenceOf(columns: readonly string[]): string | null {
  const axes = new Set(columns.map((name) => /^[A-Z]\.([xy])\.following_error$/.exec(name)?.[1]));
  const [axis] = axes;
  return axes.size === 1 && axis ? `${axis}.position_reference` : null;
}

/** The median speed of a path, about which the server linearises the loop, m/s; null of a point. */
export function medianSpeed(path: readonly (number | null)[], period: number): number | null {
  const speeds = path
    .flatMap((place, i) => {
      const before = path[i - 1];
      return place === null || before === null || before === undefined
        ? []
        : [Math.abs(place - before) / period];
    })
    .sort((a, b) => a - b);
  return speeds[Math.floor(speeds.length / 2)] ?? null;
}

/** Of a kept run. */
export class KeptSource implements ViewSource {
  problem = $state('');
  private run = $state.raw<RunDetail | null>(null);

  constructor(
    private readonly id: string,
    /** The run, where it is known already. */
    run: RunDetail | null = null,
  ) {
    this.run = run;
    if (run) return;
    getRun(id).then(
      (loaded) => (this.run = loaded),
      (error: unknown) => (this.problem = errorText(error)),
    );
  }

  get title(): string {
    return this.run?.name ?? this.id;
  }

  readonly names = $derived(this.run?.variants.slice(0, 2) ?? []);
  readonly scenario = $derived((this.run?.scenario_document ?? null) as Scenario | null);
  readonly channels: readonly Channel[] = $derived(
    (this.run?.columns ?? []).map(({ name = '', unit }) => ({ name, unit: unit ?? '1' })),
  );

  get subject(): Subject | null {
    return this.run && { run: this.id };
  }

  get version(): string {
    return this.run ? this.id : '';
  }

  get period(): number {
    return this.run?.period ?? PERIOD;
  }

  readonly home = $derived.by((): Range | null => {
    const { run } = this;
    if (!run) return null;
    const { window } = run.result as { window?: { start: number; end: number } };
    const begun = run.first_tick * run.period;
    return window
      ? { from: Math.max(0, window.start - begun), to: Math.min(run.duration, window.end - begun) }
      : { from: 0, to: run.duration };
  });

  async samples(columns: readonly string[], range: Range): Promise<Sampled> {
    const source =
      this.run && (await new RunSource(this.run).samples(columns, lastOf(range, this.period)));
    if (!source) throw new Error('The run has none of these channels.');
    return samplesOf(source, columns, 0, source.last);
  }

  spectrum(columns: readonly string[], range: Range, settings: SpectrumSettings) {
    if (!this.run) throw new Error(NOTHING);
    const ticks = ticksOf(range, this.run);
    return runSpectrum(this.id, { columns: columns.join(','), ...ticks, ...settings });
  }
}
