/** Variants on the drives, one motion after another; those before lie behind the present one. */

import { ApiError } from '../../../app/api/client';
import type { Metrics } from '../../../app/api/types';
import { control } from '../../../app/drive/control.svelte';
import { messages } from '../../../app/messages.svelte';
import { getRun } from '../../../parts/runs/runs-api';
import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { onDemand } from '../on-demand.svelte';
import { keepSequence, keptSequence, type Sequence, runText, whyNot } from './drive-rules';

export type Machine = 'simulation' | 'drive';

const LOOK = 50; // ms
/** For drives to come to rest after a motion, and for a run to be written, ms. */
const PATIENCE = 20_000;
const MACHINE = 'machine';

class DriveRuns {
  machine = $state(load<Machine>(MACHINE, 'simulation'));
  /** The variant that moves; empty while none does. */
  moving = $state('');
  readonly noRun = $derived(
    whyNot({
      status: app.drive.status,
      silent: app.drive.silent,
      held: control.held,
      moving: this.moving,
    }),
  );
  private sequence = $state.raw<Sequence | null>(null);
  /** Variants of a sequence that was interrupted while one of them moved. */
  readonly left = $derived(
    this.moving === '' && app.session.id === this.sequence?.motions.at(-1)
      ? this.sequence.left
      : [],
  );
  readonly text = $derived(
    this.moving === ''
      ? runText(this.left.length > 0 ? this.left : app.variants)
      : app.drive.known
        ? `${this.moving} moves`
        : `${this.moving} moved when last seen`,
  );
  private ghosts: readonly string[] = [];

  constructor() {
    if (this.machine === 'drive') void app.try(() => this.resume());
  }

  /** Simulates, or runs on drives, from now on; a motion that has begun goes on. */
  async choose(machine: Machine): Promise<void> {
    this.machine = machine;
    save(MACHINE, machine);
    if (machine === 'simulation' && app.session.variant !== '') {
      await app.session.leaveMotion();
      await app.afterLoad();
    }
  }

  /** Runs what is left of a sequence, or every variant of the controls, in turn. */
  async run(again = false): Promise<void> {
    if (this.noRun !== '') return;
    const scenario = app.session.info?.scenario;
    if (!scenario) return;
    const goesOn = this.left.length > 0 && !again;
    let motions: readonly string[] = goesOn ? (this.sequence?.motions ?? []) : [];
    let left: readonly string[] = goesOn ? this.left : app.variants;
    if (!goesOn) this.clearGhosts();
    app.setMode('live');
    const leave = app.drive.follow();
    try {
      for (let [variant] = left; variant !== undefined; [variant] = left) {
        this.moving = variant;
        const earlier = await metricsOf(motions);
        if (motions.length > 0) await this.layBehind();
        await this.hold();
        // With what was changed since the one before began.
        const request = { ...control.lease, body: { scenario, set: app.draft, variant } };
        const motion = await app.api.json('post', '/drive/motions', request);
        [motions, left] = [[...motions, motion.id], left.slice(1)];
        this.keep({ motions, left, ghosts: this.ghosts });
        app.session.showMotion(motion);
        await app.afterLoad(earlier);
        if (!(await this.finished(motion.id))) left = [];
      }
      this.keep(null);
    } finally {
      this.moving = '';
      leave();
    }
  }

  /** Shows the motion during which the page was loaded anew; what is left waits for the button. */
  private async resume(): Promise<void> {
    const kept = keptSequence();
    const last = kept?.motions.at(-1);
    if (!kept || last === undefined) return;
    this.ghosts = kept.ghosts;
    while (!app.session.info) await pause();
    try {
      const motion = await app.api.session(last);
      this.moving = Object.keys(motion.scenario.variants)[0] ?? '';
      app.session.showMotion(motion);
      await app.afterLoad(await metricsOf(kept.motions.slice(0, -1)));
      const sound = await this.finished(last);
      this.keep(sound && kept.left.length > 0 ? kept : null);
    } catch (error) {
      this.keep(null);
      if (!(error instanceof ApiError) || error.status !== 404) throw error;
    } finally {
      this.moving = '';
    }
  }

  private keep(sequence: Sequence | null): void {
    this.sequence = sequence;
    keepSequence(sequence);
  }

  private clearGhosts(): void {
    this.ghosts.forEach((id) => onDemand.overlay?.overlay.remove(id));
    this.ghosts = [];
  }

  /** Lays the run of the motion that is shown behind the next one. */
  private async layBehind(): Promise<void> {
    const run = await patiently(
      () => app.session.info?.run ?? null,
      'The motion was not recorded.',
    );
    await patiently(
      async () => (await getRun(run)).state !== 'recording' || null,
      'The run of the motion is still being written.',
    );
    await onDemand.loadOverlay();
    onDemand.overlay?.overlay.add([run]);
    this.ghosts = [...this.ghosts, run];
  }

  /** Waits until the drives hold their position. */
  private async hold(): Promise<void> {
    await patiently(() => {
      const { status } = app.drive;
      if (status?.state === 'holding') return true;
      if (status?.state === 'moving') return null;
      throw new Error(whyNot({ status, silent: '', held: control.held, moving: '' }));
    }, 'The drives do not come to rest.');
  }

  /** Waits for the end of a motion; false where it was stopped, or another session is shown. */
  private async finished(id: string): Promise<boolean> {
    for (;;) {
      const { info } = app.session;
      if (info?.id !== id || info.state === 'stopped') break;
      if (info.state === 'finished') return true;
      await pause();
    }
    const fault = app.drive.status?.fault;
    if (fault) messages.error(`The drives stopped: ${fault.name}. ${fault.remedy}`);
    return false;
  }
}

/** Metrics of the variants of motions that have ended. */
async function metricsOf(motions: readonly string[]): Promise<Metrics['variants']> {
  const all = await Promise.all(motions.map((id) => app.api.metrics(id)));
  return Object.assign({}, ...all.map(({ variants }) => variants)) as Metrics['variants'];
}

function pause(): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, LOOK));
}

/** Asks until there is an answer; an error with this text where there is none for long. */
async function patiently<T>(ask: () => Promise<T | null> | T | null, problem: string): Promise<T> {
  const until = performance.now() + PATIENCE;
  for (;;) {
    const answer = await ask();
    if (answer !== null) return answer;
    if (performance.now() > until) throw new Error(problem);
    await pause();
  }
}

export const driveRuns = new DriveRuns();
