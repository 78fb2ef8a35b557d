/** The result that the Lab shows, staged or in the motor, for headline and metrics alike. */

import { app } from '../../app/store.svelte';
import { LoopMargins } from '../../parts/loop/loops.svelte';
import { driveEmptyText } from './headline';
import { onDemand } from './on-demand.svelte';
import { spanText } from '../../ui/units';

class LabResult {
  readonly metrics = $derived(
    app.mode === 'whatif' ? (app.whatif.answer?.result ?? null) : app.metrics.current,
  );

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

/** The loops of the controllers that the Lab shows. */
export const labLoops = new LoopMargins(app.api);
