/** What the scopes of the Lab show: the what-if or the running session. */

import type { Checked, Whose } from '../../../app/expressions/expressions.svelte';
import { captureErrorText } from '../../../app/error-text';
import { AXES, type Axis } from '../../../app/api/types';
import { nameOf } from '../../../app/fields/fields.svelte';
import { LiveSource } from '../../../scopes/live-source';
import { Layout } from '../../../scopes/layout.svelte';
import type { Peak } from '../../../scopes/peaks';
import { STATISTICS, type Statistic } from '../../../scopes/statistics';
import type { Capture, Origin } from '../../../scopes/trigger/captures';
import { TimeView } from '../../../scopes/time-view.svelte';
import { gathered } from '../../../app/session/moments.svelte';
import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { Ring } from '../../../app/stream/ring';
import { isMath } from '../../../plot/math-column';
import type { Range } from '../../../plot/range';
import type { Moment } from '../../../plot/scope-chart';
import type { Channel, SampleSource, StillSource } from '../../../plot/source';
import { LAYOUTS, retargeted, type Scope } from '../../../plot/scope-catalog';
import type { Underlay } from '../../../plot/run-overlay';
import { digits } from '../../../ui/units';
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
  override statistic = $state<Statistic>(keptStatistic());
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
      ...AXES.flatMap((axis) => [`${axis}.velocity_reference`, `${axis}.acceleration_reference`]),
    ]),
  ]);

  readonly moments = $derived.by((): readonly Moment[] => {
    const planned = (app.scenario?.schedule ?? []).map(({ time, set }) => ({
      time,
      label: labelOf(set),
    }));
    if (app.mode === 'whatif') return planned;
    const { period, pushes, changes: made } = app.session.moments;
    if (period === 0) return planned;
    // A drag is many changes; played faster, they are further apart.
    const gap = DRAG * Math.max(1, app.session.speed);
    const marked = (undone: boolean, before: string) =>
      gathered(
        made.filter((each) => each.undone === undone),
        gap,
      ).map(({ time, set }) => ({ time, label: `${before}${labelOf(set)}` }));
    const changes = [...marked(false, ''), ...marked(true, 'undo ')];
    return [...planned, ...changes, ...pushes].sort((a, b) => a.time - b.time);
  });

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
    const { columns, computed } = this;
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
    if (app.mode === 'whatif') return app.whatif.over(this.range);
    return this.captured?.source ?? this.coming;
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

  async keep(capture: Capture, note: string, automatic: boolean): Promise<string> {
    const { origin, ticks, time } = capture;
    let run = '';
    if (!origin) return run;
    const { session, timeline } = origin;
    await app.try(async () => {
      const [from_tick, to_tick] = ticks;
      const name = `${app.scenario?.name ?? 'capture'} at ${digits(time, 7)} s`;
      const body = { from_tick, to_tick, timeline, name, note, automatic };
      try {
        ({ id: run } = await app.api.keepCapture(session, body));
      } catch (error) {
        throw new Error(captureErrorText(error), { cause: error });
      }
    });
    return run;
  }

  /** What a trigger has captured of the session, and shows. */
  private get captured(): Capture | null {
    return app.mode === 'live' ? this.trigger.shown : null;
  }

  /** What the time axis covers by itself: the window of the metrics, or the newest samples. */
  get home(): Range {
    if (app.mode === 'whatif') return app.whatif.home ?? { from: 0, to: this.span };
    if (this.captured) return this.captured.range;
    const to = Math.max(this.live.last * this.live.step, this.span);
    return { from: to - this.span, to };
  }

  get extent(): Range {
    if (app.mode === 'whatif') return app.whatif.extent ?? this.home;
    if (this.captured) return this.captured.range;
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
    if (app.mode === 'live')
      return { source: this.captured?.source ?? this.live, range: this.extent };
    const { whole } = app.whatif;
    return whole && { source: whole.source, range: this.extent };
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

  override readonly whyOf = ({ column }: Peak): (() => void) | null => {
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
    if (app.mode === 'whatif') app.whatif.look(this.range);
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
