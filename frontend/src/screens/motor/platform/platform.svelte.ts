/** Which platforms are bent, and how far, while numbers change. */

import type { Axis, FieldEntry, MapEntry, PlatformDocument, Value } from '../../../app/api/types';
import { app } from '../../../app/store.svelte';
import { InstantForm } from '../../../study/study-form.svelte';
import { bodyOf, FORCE, inRequest, valueIn } from './platform-fields';

/** What a reset leaves as it is. */
const CHOICES = ['axis', 'new.support', 'map.name'];

class Platform extends InstantForm<PlatformDocument> {
  /** Maps that can pull at the platforms. */
  maps = $state.raw<readonly MapEntry[]>([]);

  async start(): Promise<void> {
    this.ask();
    await app.try(async () => {
      this.maps = await app.api.maps();
    });
  }

  /** Turns to the other platform, whose shapes are others. */
  turn(axis: Axis): void {
    this.change({ axis });
    this.reset();
  }

  override body(): Record<string, unknown> {
    return bodyOf(this.entered, this.text('axis'), this.text('new.support'));
  }

  override alias(path: string): string {
    return inRequest(path);
  }

  override entry(path: string): FieldEntry | undefined {
    const entry = super.entry(path);
    return entry && path === FORCE ? { ...entry, default: 0 } : entry;
  }

  protected override request(): Promise<PlatformDocument> {
    return app.api.platform(this.body());
  }

  protected override usual(path: string): Value {
    if (path === 'map.name') return '';
    return CHOICES.includes(path) ? super.usual(path) : valueIn(this.answer, path);
  }

  protected override lasts(path: string): boolean {
    return CHOICES.includes(path);
  }
}

export const platform = new Platform('platform');
