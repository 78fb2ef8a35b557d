/** The curves of a run that is played: the scopes of the Lab, and a moment that moves along. */

import { AXES, type Axis, type RunDetail } from '../../../app/api/types';
import { overlay } from '../../../parts/overlay/overlay.svelte';
import type { Range } from '../../../plot/range';
import { behind, type Underlay } from '../../../plot/run-overlay';
import { LAYOUTS, retargeted, type Scope } from '../../../plot/scope-catalog';
import type { ScopeSpec } from '../../../plot/scope-layout';
import { lookOf, readLook, rounded, takeLook, type Look } from '../../../scopes/look';
import { RunCurves } from '../run-curves.svelte';
import { errorScopes, pageOf, planePage, withoutPlane } from '../run-window';
import { advanced, otherSpeed } from './playback';

/** Steps of the keys, as a share of what is visible. */
const STEP = 0.01;

interface PlayedLook extends Look {
  /** The moment that is played. */
  at?: unknown;
  of?: unknown;
  scopes?: unknown;
  layout?: unknown;
  open?: unknown;
}

export class PlayedCurves extends RunCurves {
  playing = $state(false);
  speed = $state(1);
  subject = $state({ variant: '', axis: 'x' as Axis });
  private now = $state(0);
  private readonly page = $derived(pageOf(this.now));

  constructor(run: RunDetail) {
    super(run, 'runs.large.layout');
    const variant = run.variants.includes('B') ? 'B' : (run.variants[0] ?? '');
    this.subject = { variant, axis: 'x' };
  }

  /** How it is looked at, as an address has it. */
  get lookText(): string {
    const { layout, subject } = this;
    return JSON.stringify({
      ...lookOf(this),
      at: rounded(this.now),
      of: [subject.variant, subject.axis],
      ...layout.parameters,
    });
  }

  /** Takes what an address says; what is damaged is left out. */
  takeLook(text: string): void {
    const look = readLook<PlayedLook>(text);
    const { of, at, scopes, layout, open } = look;
    if (Array.isArray(of) && this.run.variants.includes(String(of[0]))) {
      this.subject = { variant: String(of[0]), axis: of[1] === 'y' ? 'y' : 'x' };
    }
    this.layout.readParameters({ scopes, layout, open });
    takeLook(this, look);
    this.now = Math.min(this.end, Math.max(0, Number(at) || 0));
  }

  /** Time of the last sample. */
  get end(): number {
    return Math.max(0, this.run.ticks - 1) * this.run.period;
  }

  get time(): number {
    return this.now;
  }

  /** Variants and axes that currents, forces and motion can be shown of. */
  get subjects() {
    return this.run.variants
      .slice(0, 2)
      .flatMap((variant) => AXES.map((axis) => ({ variant, axis })));
  }

  setSubject(variant: string, axis: Axis): void {
    const from = { ...this.subject };
    this.layout.map((spec) => retargeted(spec, from, { variant, axis }));
    this.subject = { variant, axis };
  }

  /** Goes to a moment; the time axis follows where it would be left. */
  seek(time: number): void {
    const now = Math.min(this.end, Math.max(0, time));
    this.now = now;
    const { zoom } = this;
    if (!zoom || (now >= zoom.from && now <= zoom.to)) return;
    const length = zoom.to - zoom.from;
    const from = now > zoom.to ? now : now - length;
    this.look({ from, to: from + length });
  }

  /** Goes by a share of what is visible. */
  step(share: number): void {
    this.playing = false;
    this.seek(this.now + share * STEP * (this.range.to - this.range.from));
  }

  /** Goes by samples. */
  stepSamples(count: number): void {
    this.playing = false;
    const { period } = this.run;
    this.seek((Math.round(this.now / period) + count) * period);
  }

  playOrPause(): void {
    if (!this.playing && this.now >= this.end) this.seek(0);
    this.playing = !this.playing;
  }

  faster(steps: number): void {
    this.speed = otherSpeed(this.speed, steps);
  }

  /** Plays on by some seconds of the clock on the wall. */
  advance(elapsed: number): void {
    if (!this.playing) return;
    const { speed, end } = this;
    const { time, ended } = advanced(this.now, { elapsed, speed, end });
    this.seek(time);
    if (ended) this.playing = false;
  }

  /** The moment of the readings: of two cursors the second, as in the Lab, until one goes elsewhere. */
  override get moment(): number {
    const { playing, now, cursors } = this;
    return playing || cursors[1] === now ? now : (this.hover ?? now);
  }

  /** The moment that is played, where no cursor stands. */
  override get playhead(): number | null {
    return this.cursors.includes(this.now) ? null : this.now;
  }

  override setCursor(time: number): void {
    super.setCursor(time);
    if (this.cursors.length > 0) this.seek(time);
  }

  override dragCursor(index: number, time: number): void {
    super.dragCursor(index, time);
    this.seek(time);
  }

  override readonly behind = (scope: Scope, range: Range): readonly Underlay[] => {
    return behind(
      overlay.list.filter(({ id }) => id !== this.run.id),
      scope,
      range,
    );
  };

  protected override shipped(name: string): readonly ScopeSpec[] {
    const { run, subject } = this;
    const layout = LAYOUTS.find((each) => each.name === name) ?? LAYOUTS[0];
    return run.variants.length > 0
      ? (layout?.scopes(run.variants, subject) ?? [])
      : errorScopes(run);
  }

  protected override chosenPlane(): Range | null {
    return this.run.ticks === 0 || withoutPlane(this.run) ? null : planePage(this.page, this.run);
  }
}
