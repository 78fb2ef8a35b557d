/** Whether the 3-D view is open and what it shows; kept in the address. */

import { fromAddress, load, save, setAddress } from '../../../app/storage';
import { CAMERAS, read, type SceneChoice, written } from './scene-choice';

const KEY = 'view3d';
export type Tab = 'plane' | 'view3d';

class SceneView {
  tab = $state<Tab>(fromAddress(KEY) === null ? 'plane' : 'view3d');
  choice = $state.raw<SceneChoice>(read(fromAddress(KEY) ?? load(KEY, '' as string)));
  /** Counts up with each press of a camera's button: the same again places it anew. */
  aims = $state(0);

  get filled(): boolean {
    return this.tab === 'view3d' && this.choice.filled;
  }

  show(tab: Tab): void {
    this.tab = tab;
    this.keep();
  }

  change(changes: Partial<SceneChoice>): void {
    this.choice = { ...this.choice, ...changes };
    if ('camera' in changes) this.aims += 1;
    this.keep();
  }

  nextCamera(): void {
    const i = CAMERAS.indexOf(this.choice.camera);
    this.change({ camera: CAMERAS[(i + 1) % CAMERAS.length] ?? 'overview' });
  }

  /** Fills the page with the view, which is opened for it, or gives the page back. */
  fill(): void {
    const filled = !this.filled;
    this.tab = 'view3d';
    this.change({ filled });
  }

  private keep(): void {
    const text = written(this.choice);
    save(KEY, text);
    setAddress({ [KEY]: this.tab === 'view3d' ? text : '' });
  }
}

export const scene = new SceneView();
