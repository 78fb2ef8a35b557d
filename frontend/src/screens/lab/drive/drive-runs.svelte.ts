/** Variants on the drives, one motion after another; those before lie behind the present one. */

import type { Metrics } from '../../../app/api/types';
import { control } from '../../../app/drive/control.svelte';
import { messages } from '../../../app/messages.svelte';
import { getRun } from '../../../app/runs/runs-api';
import { load, save } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { parts } from '../parts.svelte';
import { runText, whyNot } from './why-not';

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
  readonly text = $derived(this.moving === '' ? runText(app.variants) : `${this.moving} moves`);
  private ghosts: string[] = [];

  /** Simulates, or runs on drives, from now on; a motion that has begun goes on. */
  async choose(machine: Machine): Promise<void> {
    this.machine = machine;
    save(MACHINE, machine);
    if (machine === 'simulation' && app.session.variant !== '') {
      await app.session.leaveMotion();
      await app.afterLoad();
    }
  }

  /** Runs every variant of the controls in turn. */
  async run(): Promise<void> {
    if (this.noRun !== '') return;
    const scenario = app.session.info?.scenario;
    if (!scenario) return;
    this.ghosts.forEach((id) => parts.overlay?.overlay.remove(id));
    this.ghosts = [];
    app.setMode('live');
    const leave = app.drive.follow();
    let earlier: Metrics['variants'] = {};
    try {
      for (const variant of app.variants) {
        this.moving = variant;
        if (Object.keys(earlier).length > 0) await this.layBehind();
        await this.hold();
        // With what was changed since the one before began.
        const request = { ...control.lease, body: { scenario, set: app.draft, variant } };
        const motion = await app.api.json('post', '/drive/motions', request);
        app.session.showMotion(motion);
        await app.afterLoad(earlier);
        if (!(await this.finished(motion.id))) return;
        earlier = { ...earlier, ...(await app.api.metrics(motion.id)).variants };
      }
    } finally {
      this.moving = '';
      leave();
    }
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
    await parts.loadOverlay();
    parts.overlay?.overlay.add([run]);
    this.ghosts.push(run);
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
