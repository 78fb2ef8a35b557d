/** Parts of the Lab that are loaded when they are first used; null until then. */

import type * as drive from './drive/DriveTransport.svelte';
import type * as study from './montecarlo/StudyBody.svelte';
import type * as learning from './learning/LearningBody.svelte';
import type * as gallery from './gallery/GallerySheet.svelte';
import type * as why from './why/WhySheet.svelte';
import type * as overlay from './overlay/lab-overlay';
import type { Axis } from '../../app/api/types';
import { app } from '../../app/store.svelte';
import { fromAddress, load } from '../../app/storage';

class OnDemand {
  study = $state.raw<typeof study | null>(null);
  learning = $state.raw<typeof learning | null>(null);
  overlay = $state.raw<typeof overlay | null>(null);
  drive = $state.raw<typeof drive | null>(null);
  why = $state.raw<typeof why | null>(null);
  gallery = $state.raw<typeof gallery | null>(null);
  /** Whether the gallery of examples is open. */
  choosesExample = $state(false);

  /** Loads what the address or this browser has used before. */
  start(): void {
    if (fromAddress('overlay')) void this.loadOverlay();
    if (load('job.monte-carlo', '') !== '') void this.loadStudy();
  }

  loadStudy = () =>
    app.try(async () => {
      await app.catalogue.loadRequests(['monte-carlo']);
      this.study ??= await import('./montecarlo/StudyBody.svelte');
    });

  loadLearning = () =>
    app.try(async () => {
      await app.catalogue.loadRequests(['learn']);
      this.learning ??= await import('./learning/LearningBody.svelte');
    });

  loadOverlay = () =>
    app.try(async () => {
      this.overlay ??= await import('./overlay/lab-overlay');
    });

  /** Where the server has a drive link. */
  loadDrive = () =>
    app.try(async () => {
      this.drive ??= await import('./drive/DriveTransport.svelte');
    });

  /** Whether runs are on drives, one variant after another. */
  get onDrive(): boolean {
    return this.drive?.driveRuns.machine === 'drive';
  }

  /** Whether causes can be taken away: what a drive measures is not simulated. */
  get canAskWhy(): boolean {
    return app.scenario !== null && app.session.variant === '';
  }

  /** Asks why the error peaks, of whom and on which axis, and opens the sheet that says so. */
  askWhy = (of?: { variant?: string; axis: Axis | null }) =>
    app.try(async () => {
      await app.catalogue.loadRequests(['why']);
      this.why ??= await import('./why/WhySheet.svelte');
      const { why } = this.why;
      if (of) why.change({ ...of });
      why.shown = true;
    });

  /** Opens the gallery of examples. */
  chooseExample = () =>
    app.try(async () => {
      this.gallery ??= await import('./gallery/GallerySheet.svelte');
      this.choosesExample = true;
    });

  /** Opens the sheet with runs to draw behind the curves. */
  chooseRuns = async () => {
    await this.loadOverlay();
    if (this.overlay) this.overlay.overlay.choosing = true;
  };
}

export const onDemand = new OnDemand();
