/** The trigger of a view: waits for its conditions, captures what is around, and shows it. */

import type { GhostRun } from '../../plot/run-overlay';
import type { Range } from '../../plot/range';
import type { SampleSource, StillSource } from '../../plot/source';
import { load, save } from '../../app/storage';
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
  /** Whether captures of a session become runs. */
  keep: boolean;
}

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
  keep: false,
};

/** What a trigger needs of its view. */
export interface Watched {
  readonly columns: readonly string[];
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
  /** Keeps a capture as a run; returns its identifier, empty if it could not. */
  keep?(capture: Capture, note: string, automatic: boolean): Promise<string>;
}

/** `off`: scopes show what they show. `waiting` for a hit, `searching` a record, `done`: as many as wanted. */
export type Phase = 'off' | 'waiting' | 'searching' | 'done';

export class Trigger {
  /** Whether its panel is open. */
  open = $state(false);
  phase = $state<Phase>('off');
  settings = $state.raw<Settings>(USUAL);
  captures = $state.raw<readonly Capture[]>([]);
  /** The capture that is shown; -1 for none. */
  place = $state(-1);
  overlay = $state(false);
  average = $state(false);
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

  readonly shown: Capture | null = $derived(this.captures[this.place] ?? null);

  readonly behind: readonly GhostRun[] = $derived.by(() => {
    const { shown, captures, overlay, average } = this;
    return shown ? laidBehind(captures, shown, this.view.columns, { overlay, average }) : [];
  });

  constructor(private readonly view: Watched) {
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

  /** Forgets the captures and waits for the next hit, or finds those of what is in view. */
  arm(): void {
    const { shown, view } = this;
    const same = shown?.range.from === view.range.from && shown.range.to === view.range.to;
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
    const { shown, view, searched } = this;
    if (shown && !view.coming) view.look(searched);
    this.clear();
    this.phase = 'off';
  }

  private clear(): void {
    this.search += 1;
    this.captures = [];
    this.place = -1;
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
    const kept = this.captures.filter((each) => !each.free);
    const ticks = [first, first + count] as const;
    const origin = this.view.origin ?? null;
    const capture = { time: tick * period, range, source, free, origin, ticks, run: '' };
    this.captures = [...kept, capture];
    if (this.settings.keep && !free) void this.keep(capture, true);
    this.place = this.captures.length - 1;
    this.view.look(null);
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
      for (const tick of hits.slice(0, most)) {
        const from = Math.max(extent.from, (tick - before) * period);
        const range = { from, to: Math.min(extent.to, (tick - before + count) * period) };
        const part = await view.samples(view.columns, range);
        if (search !== this.search) return;
        if (!part) continue;
        this.captures = [
          ...this.captures,
          {
            time: tick * period,
            range,
            source: part,
            free: false,
            origin: null,
            ticks: [tick - before, tick - before + count],
            run: '',
          },
        ];
        if (this.place < 0) this.show(0);
      }
      this.phase = 'done';
    } catch (error) {
      if (search !== this.search) return;
      this.problem = error instanceof Error ? error.message : String(error);
      this.phase = 'done';
    }
  }

  /** Whether captures become runs from now on; those that there are stay as they are. */
  keepFromNow(keep: boolean): void {
    this.settings = { ...this.settings, keep };
    save(KEPT, this.settings);
  }

  /** Keeps a capture of a session as a run; one that is kept as it comes may be evicted. */
  async keep(capture: Capture, automatic = false): Promise<void> {
    const { view } = this;
    const note = triggerText(this.settings);
    this.note(capture, '…');
    this.note(capture, (await view.keep?.(capture, note, automatic)) ?? '');
  }

  private note({ source }: Capture, run: string): void {
    this.captures = this.captures.map((each) => (each.source === source ? { ...each, run } : each));
  }

  /** Shows another capture. */
  show(place: number): void {
    if (place < 0 || place >= this.captures.length) return;
    this.place = place;
    const { shown, view } = this;
    view.look(view.coming ? null : (shown?.range ?? null));
  }
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
