/** What the scopes of the Lab show: the what-if or the running session. */

import type { Checked, Whose } from '../../../app/expressions/expressions.svelte';
import { captureErrorText } from '../../../app/error-text';
import { AXES, type Axis, type Run } from '../../../app/api/types';
import { demo, NEEDS_SERVER } from '../../../app/demo/demo-mode';
import { nameOf } from '../../../app/fields/fields.svelte';
import { LiveSource } from '../../../scopes/live-source';
import { Layout } from '../../../scopes/layout.svelte';
import { STATISTICS, type Statistic } from '../../../scopes/statistics';
import type { Capture, Origin } from '../../../scopes/trigger/captures';
import type { About } from '../../../scopes/trigger/trigger.svelte';
import { TimeView } from '../../../scopes/time-view.svelte';
import { clockMarks } from '../../../app/session/clock-marks';
import { lawMark } from '../../../app/session/law-text';
import { gathered } from '../../../app/session/moments.svelte';
import { person } from '../../../app/session/person.svelte';
import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { Ring } from '../../../app/stream/ring';
import { isMath } from '../../../plot/math-column';
import type { Range } from '../../../plot/range';
import type { Moment } from '../../../plot/scope-chart';
import type { Channel, SampleSource, StillSource } from '../../../plot/source';
import { LAYOUTS, retargeted, type Scope } from '../../../plot/scope-catalog';
import type { Underlay } from '../../../plot/run-overlay';
import { onDemand } from '../on-demand.svelte';

export const SPANS = [1, 2, 5, 10, 20, 30] as const;

/** Curves' readouts change this often at most, ms. */
const READOUT = 100;

/** Changes closer together than this have one mark, s. */
const DRAG = 1;

const NO_RING = new Ring(0, []);

const FOLLOWING_ERROR = /^([A-Z])\.([xy])\.following_error$/;
const SIMULATED_ONLY =
  /^[A-Z]\.[xy]\.(position|velocity|acceleration|friction|bristle|thrust|normal_force)$/;

class View extends TimeView {
  variant = $state(load('variant', 'B'));
  axis = $state<Axis>(load<string>('axis', 'x') === 'y' ? 'y' : 'x');
  span = $state<number>(load('span', 10));
  /** Whether the scopes have the whole page. */
  filled = $state(false);
  override statistic = $state<Statistic>(keptStatistic());
  /** Columns that pictures need besides those of the scopes, while they are shown. */
  pictured = $state.raw<readonly string[]>([]);
  readonly layout = new Layout({
    key: 'layout',
    linked: true,
    shipped: (name) => {
      const layout = LAYOUTS.find((each) => each.name === name) ?? LAYOUTS[0];
      const { subject: variant, axis } = this;
      return layout?.scopes(app.variants, { variant, axis }) ?? [];
    },
  });
  private readonly live = new LiveSource(
    () => app.session.client?.ring ?? NO_RING,
    () => app.session.moments.period,
  );

  /** The variant that currents and forces are shown of. */
  readonly subject = $derived(
    app.variants.includes(this.variant) ? this.variant : (app.variants[0] ?? 'A'),
  );

  /** Columns of a what-if: those, and what the trajectory's peaks are read off. */
  readonly previewColumns = $derived([
    ...new Set([
      ...this.columns,
      ...this.pictured,
      ...AXES.flatMap((axis) => [`${axis}.velocity_reference`, `${axis}.acceleration_reference`]),
    ]),
  ]);

  readonly moments = $derived.by((): readonly Moment[] => {
    const planned = (app.scenario?.schedule ?? []).map(({ time, set }) => ({
      time,
      label: labelOf(set),
    }));
    if (app.mode === 'whatif') return planned;
    const { moments } = app.session;
    // A drag is many changes; played faster, they are further apart.
    const gap = DRAG * Math.max(1, app.session.speed);
    const changes = gathered(moments.changes, gap).map(({ time, set, undone, by }) => {
      const label = `${undone ? 'undo ' : ''}${labelOf(set)}${person.other(by)}`;
      return { time, label };
    });
    const others = [...moments.of('push'), ...moments.of('stop')].map(({ time, event }) => {
      const what = event.kind === 'push' ? `push ${event.axis}` : 'STOP';
      return { time, label: what + person.other(event.by) };
    });
    const laws = moments.of('law').map(({ time, event }) => ({ time, label: lawMark(event) }));
    return [...planned, ...changes, ...others, ...laws].sort((a, b) => a.time - b.time);
  });

  override get clock(): readonly Moment[] {
    if (app.mode === 'whatif') return [];
    const { events, period } = app.session.moments;
    const marks = clockMarks(events, (by) => person.other(by));
    return marks.map(({ tick, label }) => ({ time: tick * period, label }));
  }

  get channels(): readonly Channel[] {
    return app.session.channels;
  }

  get variants(): readonly string[] {
    return app.variants;
  }

  get whose(): Whose {
    return { variants: app.variants };
  }

  /** Columns of the stream: all but those that are computed, and what these are computed from. */
  readonly streamed: readonly string[] = $derived.by(() => {
    const { computed } = this;
    const more = this.pictured.filter((column) => !this.columns.includes(column));
    const columns = more.length > 0 ? [...this.columns, ...more] : this.columns;
    if (!columns.some(isMath)) return columns;
    const sources = computed.flatMap(({ channels }) => channels);
    return [...new Set([...columns.filter((column) => !isMath(column)), ...sources])];
  });

  /** What is computed from the samples of the stream. */
  readonly computed: readonly Checked[] = $derived.by(() =>
    this.columns.flatMap((column) => {
      const channel = isMath(column) ? app.expressions.of(this.whose, column) : undefined;
      return channel && !channel.problem ? [channel] : [];
    }),
  );

  get period(): number {
    return app.session.moments.period;
  }

  override get state(): string {
    return app.mode === 'live' ? 'live' : 'what-if';
  }

  get source(): SampleSource | null {
    if (this.captured) return this.captured.source;
    return app.mode === 'whatif' ? app.whatif.over(this.range) : this.coming;
  }

  override get coming(): SampleSource | null {
    return app.mode === 'live' && app.session.moments.period > 0 ? this.live : null;
  }

  override get basis(): unknown {
    return app.mode === 'live' ? app.session.info?.id : app.whatif.whole;
  }

  samples(columns: readonly string[], range: Range): Promise<StillSource | null> {
    return app.whatif.samples(columns, range);
  }

  get origin(): Origin | null {
    const { info } = app.session;
    return info && { session: info.id, timeline: info.timeline };
  }

  resolution(axis: Axis): number {
    return app.scenario?.plant[axis].encoder.resolution ?? 0;
  }

  async keep({ origin, ticks, tick }: Capture, about: About): Promise<Run> {
    if (demo !== null) throw new Error(NEEDS_SERVER);
    const [from_tick, to_tick] = ticks;
    const { note, columns, automatic } = about;
    const body = { from_tick, to_tick, trigger_tick: tick, columns, note };
    try {
      if (origin) {
        const { session, timeline } = origin;
        return await app.api.keepCapture(session, { ...body, timeline, automatic });
      }
      const { question } = app.whatif.answer ?? {};
      if (!question) throw new Error('There is no what-if to keep it of.');
      const { scenario, set } = question;
      return await app.api.json('post', '/whatif/captures', { body: { scenario, set, ...body } });
    } catch (error) {
      throw new Error(captureErrorText(error), { cause: error });
    }
  }

  async copyLink(): Promise<void> {
    const { copyLink } = await import('../copy-link');
    await copyLink();
  }

  /** The capture that is shown in place of the session or the what-if. */
  private get captured(): Capture | null {
    const { shown } = this.trigger;
    return shown?.apart ? shown : null;
  }

  /** What the time axis covers by itself: the window of the metrics, or the newest samples. */
  get home(): Range {
    if (this.captured) return this.captured.range;
    if (app.mode === 'whatif') return app.whatif.home ?? { from: 0, to: this.span };
    const to = Math.max(this.live.last * this.live.step, this.span);
    return { from: to - this.span, to };
  }

  get extent(): Range {
    if (this.captured) return this.captured.range;
    if (app.mode === 'whatif') return app.whatif.extent ?? this.home;
    const { live } = this;
    const from = live.first * live.step;
    // A young session does not fill its time axis yet.
    return { from, to: Math.max(live.last * live.step, from + this.span) };
  }

  get window(): Range | null {
    const window = app.mode === 'whatif' ? app.whatif.answer?.result.window : null;
    return window ? { from: window.start, to: window.end } : null;
  }

  override get overview() {
    if (this.captured) return { source: this.captured.source, range: this.extent };
    if (app.mode === 'live') return { source: this.live, range: this.extent };
    // Its place is taken from the start: scopes keep theirs when the whole run has come.
    const source = app.whatif.whole?.source ?? this.source;
    return source && { source, range: this.extent };
  }

  /** The moment of the readouts: the second cursor, else under the pointer, else the newest. */
  get moment(): number {
    const { hover, source } = this;
    const [, second] = this.cursors;
    if (second !== undefined) return second;
    if (hover !== null) return hover;
    if (!source) return Number.NaN;
    const newest = source.start + source.last * source.step;
    return app.mode === 'live' ? Math.min(newest, this.range.to) : Number.NaN;
  }

  override readonly behind = (scope: Scope, range: Range): readonly Underlay[] => {
    const { study, overlay } = onDemand;
    return [
      ...(study?.study.behind(scope, this.source) ?? []),
      ...(overlay?.behind(overlay.overlay.list, scope, range) ?? []),
    ];
  };

  override readonly note = (scope: Scope): string => {
    const study = onDemand.study?.study;
    const banded = (study?.behind(scope, this.source) ?? []).length > 0;
    return banded ? `▒ 5–95 %, min–max of ${study?.result?.cases} plants` : '';
  };

  override readonly whyOf = (column: string): (() => void) | null => {
    const [, variant, axis] = FOLLOWING_ERROR.exec(column) ?? [];
    if (!variant || !axis || !onDemand.canAskWhy) return null;
    return () => void onDemand.askWhy({ variant, axis: axis as Axis });
  };

  /** On drives nothing measures the true state of the machine. */
  override readonly missing = (column: string): string => {
    const drive = app.mode === 'live' && app.session.variant !== '';
    return drive && SIMULATED_ONLY.test(column) ? 'not measured' : '';
  };

  setSubject(variant: string, axis: Axis): void {
    const from = { variant: this.subject, axis: this.axis };
    this.layout.map((spec) => retargeted(spec, from, { variant, axis }));
    this.variant = variant;
    this.axis = axis;
    save('variant', variant);
    save('axis', axis);
  }

  setSpan(span: number): void {
    this.span = span;
    this.zoom = null;
    save('span', span);
  }

  protected override looked(): void {
    if (app.mode === 'whatif' && !this.captured) app.whatif.look(this.range);
  }

  setStatistic(statistic: Statistic): void {
    this.statistic = statistic;
    save('statistic', statistic);
  }

  nextStatistic(): void {
    const i = STATISTICS.findIndex(({ id }) => id === this.statistic);
    this.setStatistic(STATISTICS[(i + 1) % STATISTICS.length]?.id ?? 'value');
  }

  /** Starts the readouts; returns what stops them. */
  start(): () => void {
    let seen = '';
    const timer = setInterval(() => {
      const key = `${this.source?.version} ${this.hover} ${this.moment}`;
      if (key !== seen) this.beat += 1;
      seen = key;
    }, READOUT);
    return () => clearInterval(timer);
  }
}

function labelOf(set: object): string {
  return Object.keys(set)
    .map((path) => nameOf(path).replace('_', ''))
    .join(', ');
}

function keptStatistic(): Statistic {
  const kept = load('statistic', '' as string);
  return STATISTICS.find(({ id }) => id === kept)?.id ?? 'value';
}

export const view = new View();
