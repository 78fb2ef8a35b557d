/** The trigger of a view: waits for its conditions, captures what is around, and shows it. */

import type { Axis, Run } from '../../app/api/types';
import { errorText } from '../../app/error-text';
import type { GhostRun } from '../../plot/run-overlay';
import type { Range } from '../../plot/range';
import type { Channel, SampleSource, StillSource } from '../../plot/source';
import { load, save } from '../../app/storage';
import { loop } from '../../ui/animation-loop';
import { KEPT_FORM } from './kept-settings';
import { type Capture, copied, laidBehind, type Origin } from './captures';
import { channelsOf, type Condition, Detector, type Join } from './detector';

/** `auto` also shows what passes while nothing triggers; `single` waits for a hand after one. */
export type Mode = 'auto' | 'normal' | 'single';

export interface Settings {
  conditions: readonly Condition[];
  join: Join;
  /** Of a capture, s. */
  length: number;
  /** What lies before its trigger, as a share of that. */
  before: number;
  /** s */
  holdOff: number;
  mode: Mode;
  /** Captures until it stops. */
  most: number;
}

/** What is said of a capture that is kept. */
export interface About {
  note: string;
  /** Channels of the trigger. */
  columns: string[];
  /** Whether it is kept as it comes: then it may be evicted. */
  automatic: boolean;
}

/** Most captures, beside those of the present trigger, whose samples are here. */
const OPENED_MAX = 50;

const VELOCITY = /^[xy]\.velocity_reference$/;

/** Where the browser keeps the settings, for all screens. */
const KEPT = 'trigger';

const USUAL: Settings = {
  conditions: [{ kind: 'reversal', channel: 'x.velocity_reference', slope: 'either' }],
  join: 'or',
  length: 0.2,
  before: 0.25,
  holdOff: 0,
  mode: 'normal',
  most: 10,
};

/** What a trigger needs of its view. */
export interface Watched {
  readonly columns: readonly string[];
  readonly known: readonly Channel[];
  readonly range: Range;
  readonly extent: Range;
  readonly period: number;
  readonly moments: readonly { time: number }[];
  /** Samples that come while one looks; null where all are there already. */
  readonly coming: SampleSource | null;
  /** Every sample of a stretch of what is there already. */
  samples(columns: readonly string[], range: Range): Promise<StillSource | null>;
  look(range: Range | null): void;
  /** The session whose samples come. */
  readonly origin?: Origin | null;
  /** Keeps a capture as a run, and throws why it could not; where captures are kept. */
  keep?(capture: Capture, about: About): Promise<Run>;
  /** Copies an address that shows a capture as it is shown here; where captures are kept. */
  copyLink?(): Promise<void>;
  /** Of the encoder of an axis, m; 0 where it is not known. */
  resolution?(axis: Axis): number;
}

/** `off`: scopes show what they show. `waiting` for a hit, `searching` a record, `done`: as many as wanted. */
export type Phase = 'off' | 'waiting' | 'searching' | 'done';

export class Trigger {
  /** Whether its panel is open. */
  open = $state(false);
  phase = $state<Phase>('off');
  settings = $state.raw<Settings>(USUAL);
  /** Those of this trigger, in the order of time. */
  captures = $state.raw<readonly Capture[]>([]);
  /** Those kept before whose samples are here. */
  opened = $state.raw<readonly Capture[]>([]);
  /** The capture that is shown, also while it is read; empty for none. */
  shownKey = $state('');
  /** The captures that lie behind it. */
  overlaid = $state.raw<readonly string[]>([]);
  /** Whether those that come lie behind it too. */
  overlay = $state(false);
  average = $state(false);
  /** The channel whose peaks are listed; empty for the one that the trigger is of. */
  measured = $state('');
  /** Told of each capture that has become a run. */
  kept: ((run: Run) => void) | null = null;
  /** Hits of a searched record, those beyond the captures too. */
  hitCount = $state(0);
  problem = $state('');

  private detector: Detector | null = null;
  private watching: readonly string[] = [];
  /** The tick to look at next, and hits whose stretch has not passed yet. */
  private next = 0;
  private pending: number[] = [];
  private search = 0;
  /** What was searched: looking at a capture does not narrow the next search to it. */
  private searched: Range | null = null;
  /** What is looked at for the capture that was shown last, though it may be gone by now. */
  private captured: Range | null = null;

  private unwatch: (() => void) | null = null;
  private count = 0;
  private keeping: Promise<void> = Promise.resolve();

  /** All whose samples are here. */
  readonly all: readonly Capture[] = $derived([...this.captures, ...this.opened]);
  readonly shown: Capture | null = $derived(
    this.all.find(({ key }) => key === this.shownKey) ?? null,
  );
  /** The captures without what auto shows meanwhile. */
  readonly hits: readonly Capture[] = $derived(this.captures.filter(({ free }) => !free));

  readonly behind: readonly GhostRun[] = $derived.by(() => {
    const { shown, all, hits, average } = this;
    if (!shown) return [];
    const overlaid = all.filter(({ key }) => this.overlaid.includes(key));
    const several = all.filter((each) => each === shown || overlaid.includes(each));
    const mean = average ? (several.length > 1 ? several : hits) : [];
    return laidBehind(shown, this.view.columns, { overlaid, mean });
  });

  constructor(readonly view: Watched) {
    this.settings = { ...USUAL, ...load<Partial<Settings>>(KEPT, {}, KEPT_FORM) };
  }

  /** Channels that have to come while it waits, shown or not. */
  get channels(): readonly string[] {
    return this.phase === 'off' || !this.view.coming ? [] : channelsOf(this.settings.conditions);
  }

  get armed(): boolean {
    return this.phase === 'waiting' || this.phase === 'searching';
  }

  /** Takes other settings; while it is armed, from now on. */
  set(part: Partial<Settings>): void {
    this.settings = { ...this.settings, ...part };
    save(KEPT, this.settings);
    if (this.phase !== 'off') this.arm();
  }

  /** Waits for the next hit, or finds those of what is in view; captures before stay where they are kept. */
  arm(): void {
    const { captured, view } = this;
    if (this.shown?.apart) this.shownKey = '';
    const same = captured?.from === view.range.from && captured.to === view.range.to;
    if (!same) this.searched = view.range;
    this.clear();
    this.watching = channelsOf(this.settings.conditions);
    const { coming } = this.view;
    if (!coming) {
      this.phase = 'searching';
      void this.find();
      return;
    }
    this.phase = 'waiting';
    this.restart(coming);
    // Samples come with every frame, whether its panel is open or not.
    this.unwatch ??= loop.add(() => this.poll());
  }

  /** Goes on with another record: a search is done anew, captures of a session that is gone stand. */
  renew(): void {
    if (this.phase === 'off') return;
    const { coming } = this.view;
    const ofSession = this.captures.some(({ origin }) => origin !== null);
    if (!coming || !ofSession) this.arm();
    else if (this.phase === 'waiting') this.restart(coming);
  }

  /** Back to what the scopes show without a trigger. */
  stop(): void {
    const { shown, searched } = this;
    if (shown && !shown.apart) this.look(searched);
    this.clear();
    this.shownKey = '';
    this.phase = 'off';
    this.unwatch?.();
    this.unwatch = null;
  }

  /** Forgets the captures of this trigger, but for what has become a run. */
  private clear(): void {
    this.search += 1;
    const renamed: Record<string, string> = Object.fromEntries(
      this.captures.map(({ key, run }) => [key, isRun(run) ? run : '']),
    );
    const now = (key: string) => renamed[key] ?? key;
    this.overlaid = this.overlaid.map(now).filter((key) => key !== '');
    this.shownKey = now(this.shownKey);
    const opened = this.captures.filter(({ run, apart }) => apart && isRun(run));
    this.opened = [...this.opened, ...opened.map((each) => ({ ...each, key: each.run }))].slice(
      -OPENED_MAX,
    );
    this.captures = [];
    this.hitCount = 0;
    this.problem = '';
    this.pending = [];
  }

  private restart(source: SampleSource): void {
    const { holdOff, conditions, join } = this.settings;
    const { period } = this.view;
    const marks = () => this.view.moments.map(({ time }) => time);
    this.detector = new Detector(conditions, join, Math.round(holdOff / period), marks, period);
    this.next = Math.max(source.first, source.last - 1);
    this.pending = [];
  }

  private get ticks(): { count: number; before: number } {
    const { length, before } = this.settings;
    const count = Math.max(2, Math.round(length / this.view.period));
    return { count, before: Math.round(before * count) };
  }

  /** Triggers by hand, at the newest sample. */
  hit(): void {
    const { coming } = this.view;
    if (this.phase === 'waiting' && coming) this.pending.push(coming.last - 1);
  }

  /** Looks at what has come since; once a frame while samples come. */
  poll(): void {
    const { coming } = this.view;
    if (this.phase !== 'waiting' || !coming || coming.last === 0) return;
    // A session that was reset begins anew.
    if (this.next > coming.last || this.next < coming.first) this.restart(coming);
    const { count, before } = this.ticks;
    const values: number[] = [];
    for (let tick = this.next; tick < coming.last; tick++) {
      this.watching.forEach((channel, i) => {
        values[i] = coming.at(channel, tick * coming.step);
      });
      if (this.detector?.next(tick, values)) this.pending.push(tick);
    }
    this.next = coming.last;
    while (this.phase === 'waiting') {
      const tick = this.pending[0];
      if (tick === undefined || tick - before + count > coming.last) break;
      this.pending.shift();
      if (tick - before >= coming.first) this.take(coming, tick, false);
    }
    this.runFree(coming, count);
  }

  /** Shows what passes while nothing triggers. */
  private runFree(coming: SampleSource, count: number): void {
    if (this.settings.mode !== 'auto' || this.phase !== 'waiting' || this.pending.length > 0)
      return;
    const { shown, view } = this;
    const since = shown ? coming.last - Math.round(shown.range.to / view.period) : count;
    if (since >= count && coming.last - count >= coming.first) {
      this.captures = this.captures.filter(({ free }) => !free);
      this.take(coming, coming.last - count + this.ticks.before, true);
    }
  }

  private take(coming: SampleSource, tick: number, free: boolean): void {
    const { count, before } = this.ticks;
    const { columns, period } = this.view;
    const first = tick - before;
    const source = copied(coming, columns, first, count);
    const range = { from: first * period, to: (first + count) * period };
    const capture: Capture = {
      key: this.nextKey(),
      time: tick * period,
      range,
      source,
      free,
      apart: true,
      origin: this.view.origin ?? null,
      ticks: [first, first + count],
      tick,
      run: '',
      problem: '',
    };
    this.captures = [...this.hits, capture];
    this.shownKey = capture.key;
    this.look(null);
    if (!free && this.overlay) this.tick(capture.key, true);
    // One after the other: chatter makes many at once.
    if (!free) this.keeping = this.keeping.then(() => this.keep(capture, true));
    const { mode, most } = this.settings;
    if (free) return;
    if (mode === 'single' || this.captures.length >= most) {
      this.phase = 'done';
      this.pending = [];
    }
  }

  /** Finds the hits of a record in what is visible, and reads what is around them. */
  private async find(): Promise<void> {
    const { view, watching, settings } = this;
    const search = this.search;
    const { period, extent } = view;
    const all = this.searched ?? view.range;
    const { count, before } = this.ticks;
    const { conditions, join, holdOff, mode } = settings;
    const most = mode === 'single' ? 1 : settings.most;
    try {
      const source = watching.length > 0 ? await view.samples(watching, all) : null;
      if (search !== this.search) return;
      const marks = () => view.moments.map(({ time }) => time);
      const detector = new Detector(conditions, join, Math.round(holdOff / period), marks, period);
      // Marks alone need no samples.
      const start = Math.round((source?.start ?? all.from) / period);
      const stop = source ? start + source.last : Math.round(all.to / period);
      const hits: number[] = [];
      for (let tick = start; tick < stop; tick++) {
        const time = (tick + 0.5) * period;
        const values = watching.map((channel) => source?.at(channel, time) ?? Number.NaN);
        if (detector.next(tick, values)) hits.push(tick);
      }
      this.hitCount = hits.length;
      // What glitches are measured with is read besides what is shown.
      const turning = view.known.flatMap(({ name }) => (VELOCITY.test(name) ? [name] : []));
      const columns = [...view.columns, ...turning.filter((name) => !view.columns.includes(name))];
      for (const tick of hits.slice(0, most)) {
        const from = Math.max(extent.from, (tick - before) * period);
        const range = { from, to: Math.min(extent.to, (tick - before + count) * period) };
        const part = await view.samples(columns, range);
        if (search !== this.search) return;
        if (!part) continue;
        const key = this.nextKey();
        const hit = {
          key,
          time: tick * period,
          range,
          source: part,
          free: false,
          apart: false,
          origin: null,
          ticks: [Math.round(range.from / period), Math.round(range.to / period)],
          tick,
          run: '',
          problem: '',
        } as const;
        this.captures = [...this.captures, hit];
        if (this.overlay) this.tick(key, true);
        if (this.shownKey === '') this.show(key);
      }
      this.phase = 'done';
    } catch (error) {
      if (search !== this.search) return;
      this.problem = error instanceof Error ? error.message : String(error);
      this.phase = 'done';
    }
  }

  private nextKey(): string {
    this.count += 1;
    return `capture ${this.count}`;
  }

  /** Keeps a capture as a run with every channel; one that is kept as it comes may be evicted. */
  async keep(capture: Capture, automatic = false): Promise<void> {
    const { view, settings } = this;
    if (!view.keep) return;
    const { key } = capture;
    this.change(key, { run: '…', problem: '' });
    const columns = channelsOf(settings.conditions);
    try {
      const run = await view.keep(capture, { note: triggerText(settings), columns, automatic });
      this.change(key, { run: run.id });
      this.kept?.(run);
    } catch (error) {
      this.change(key, { run: '', problem: errorText(error) });
    }
  }

  /** Takes the samples of a capture that was kept. */
  put(capture: Capture): void {
    const known = this.captures.find(({ run }) => run === capture.run);
    if (known) {
      this.change(known.key, {
        source: capture.source.shifted(known.range.from - capture.range.from),
      });
      return;
    }
    const others = this.opened.filter(({ key }) => key !== capture.key);
    this.opened = [...others, capture].slice(-OPENED_MAX);
  }

  private change(key: string, part: Partial<Capture>): void {
    this.captures = this.captures.map((each) => (each.key === key ? { ...each, ...part } : each));
  }

  /** Lays captures behind the one that is shown, or no longer. */
  tick(key: string, overlaid: boolean): void {
    const others = this.overlaid.filter((each) => each !== key);
    this.overlaid = overlaid ? [...others, key] : others;
  }

  /** Lays all captures of this trigger, and those that come, behind the one that is shown. */
  setOverlay(overlay: boolean): void {
    this.overlay = overlay;
    this.overlaid = overlay ? this.hits.map(({ key }) => key) : [];
  }

  /** Shows a capture; one that is kept and not here yet, as soon as it has been read. */
  show(key: string): void {
    const before = this.shown;
    this.shownKey = key;
    const { shown } = this;
    if (shown && !shown.apart) this.look(shown.range, shown.range);
    else if (before && !before.apart) this.look(this.searched);
    else this.look(null);
  }

  private look(range: Range | null, captured: Range | null = null): void {
    this.captured = captured;
    this.view.look(range);
  }
}

/** Whether a capture's `run` is one: `…` stands for one that is being kept. */
export function isRun(run: string): boolean {
  return run !== '' && run !== '…';
}

export function triggerText({ conditions, join }: Pick<Settings, 'conditions' | 'join'>): string {
  return `Trigger: ${conditions.map(conditionText).join(` ${join} `)}.`;
}

function conditionText(condition: Condition): string {
  switch (condition.kind) {
    case 'reversal':
      return `reversal of ${condition.channel}${condition.slope === 'either' ? '' : `, ${condition.slope}`}`;
    case 'level': {
      const { channel, slope, level, hysteresis } = condition;
      const way = { rising: 'rises to', falling: 'falls to', either: 'passes' }[slope];
      return `${channel} ${way} ${level}, hysteresis ${hysteresis}`;
    }
    case 'window': {
      const { channel, way, low, high, hysteresis } = condition;
      return `${channel} ${way} ${low} to ${high}, hysteresis ${hysteresis}`;
    }
    case 'mark':
      return 'any mark';
  }
}
