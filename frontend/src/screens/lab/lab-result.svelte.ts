/** The result that the Lab shows, staged or in the motor, for headline and metrics alike. */

import { app } from '../../app/store.svelte';
import { LoopMargins } from '../../parts/loop/loops.svelte';
import type { Metrics, Scenario } from '../../app/api/types';
import { driveEmptyText, headline } from './headline';
import { onDemand } from './on-demand.svelte';
import { spanText } from '../../ui/units';

class LabResult {
  /** What is in the motor, simulated: the last result of nothing staged. */
  private unchanged = $state.raw<{ scenario: Scenario; result: Metrics } | null>(null);

  readonly metrics = $derived(
    app.mode === 'whatif' ? (app.whatif.answer?.result ?? null) : app.metrics.current,
  );

  /** What the session has measured, or what is expected of it; null where neither is known. */
  readonly inMotor = $derived.by((): Metrics | null => {
    if (app.metrics.current) return app.metrics.current;
    const { unchanged } = this;
    return unchanged?.scenario === app.session.info?.scenario ? (unchanged?.result ?? null) : null;
  });

  /** Keeps a result of nothing staged, for when something is. */
  keepUnchanged(): void {
    const { answer, standing } = app.whatif;
    if (app.mode !== 'whatif' || standing !== 'exact' || !answer) return;
    const { scenario, set } = answer.question;
    if (Object.keys(set).length > 0 || typeof scenario === 'string') return;
    this.unchanged = { scenario, result: answer.result };
  }

  readonly shown = $derived(app.variants.slice(0, 2));

  /** When each variant that has diverged did so, s. */
  readonly diverged = $derived.by((): Readonly<Record<string, number>> => {
    const all = this.shown.flatMap((name) => {
      const time =
        app.mode === 'whatif'
          ? (this.metrics?.variants[name]?.diverged?.time ?? null)
          : (app.session.info?.diverged[name] ?? null);
      return time === null ? [] : [[name, time] as const];
    });
    return Object.fromEntries(all);
  });

  readonly span = $derived(this.metrics ? spanText(this.metrics.window) : '');

  /** Why there is no result of what is staged; empty where there is one. */
  readonly refused = $derived(
    app.mode === 'whatif' && app.whatif.standing === 'failed' ? app.whatif.reason : '',
  );

  /** What is said while there is no result. */
  readonly waiting = $derived.by((): string => {
    if (app.mode === 'whatif') {
      return app.whatif.standing === 'failed' ? 'Not computed' : 'Simulating…';
    }
    const { state } = app.session.info ?? {};
    const { variant, time } = app.session;
    if (variant !== '') return driveEmptyText(variant, state, time);
    if (onDemand.onDrive) return 'No result yet: nothing has run on the drive';
    if (state === 'playing') return 'No result yet: it has just begun';
    const stopped = state === 'stopped' || state === 'stopping';
    return `No result yet: press ${stopped ? 'Reset, then Play' : 'Play'}`;
  });
}

export const labResult = new LabResult();

/** The figure of the headline of a result: whose it is, and how much; a dash where there is none. */
export function figureOf(
  metrics: Metrics | null,
  ended?: Readonly<Record<string, number | null>>,
): { variant: string; text: string } {
  const times = labResult.shown.flatMap((name) => {
    const time = ended ? ended[name] : metrics?.variants[name]?.diverged?.time;
    return typeof time === 'number' ? [[name, time] as const] : [];
  });
  const diverged = Object.fromEntries(times);
  const { variant, figure, bad } = headline(metrics, labResult.shown, diverged, '–');
  return bad ? { variant, text: 'unstable' } : { variant, text: figure };
}

/** The loops of the controllers that the Lab shows. */
export const labLoops = new LoopMargins(app.api);
