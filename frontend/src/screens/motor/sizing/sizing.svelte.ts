/** What is sized, and what the server makes of it while numbers change. */

import type { Changes, DesignDocument, Value } from '../../../app/api/types';
import { fromAddress, setAddress } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { InstantForm, nested } from '../../../study/study-form.svelte';
import { numberIn } from '../quantity-fields';
import { BORROWED, GROUPS, withTooth, type Direction } from './sizing-fields';

export type Preset = DesignDocument['preset'];

class Sizing extends InstantForm<DesignDocument> {
  direction = $state<Direction>(
    fromAddress('direction') === 'dimensions' ? 'dimensions' : 'requirements',
  );
  readonly preset = $derived.by(() => this.text('preset') as Preset);

  protected override request(): Promise<DesignDocument> {
    const own = Object.entries(this.entered).filter(([path]) => !this.ofOther(path));
    return app.api.design(nested(Object.fromEntries(own)));
  }

  /** What was typed, else what holds; without dimensions, the choices. */
  protected override usual(path: string): Value {
    if (path === 'preset') return super.usual(path);
    const { answer } = this;
    return numberIn(
      answer && { ...answer, dimensions: answer.dimensions ?? answer.requirements },
      path,
    );
  }

  protected override lasts(path: string): boolean {
    return path === 'preset' || this.ofOther(path);
  }

  private ofOther(path: string): boolean {
    return path !== 'preset' && !path.startsWith(`${this.direction}.`);
  }

  /** Takes one number; of tooth, slot and ratio the others then follow from the pitch. */
  take(path: string, value: number): void {
    this.last = path;
    this.put(withTooth(this.entered, path, value));
  }

  choose(preset: Preset): void {
    this.put({ preset });
  }

  turn(direction: Direction): void {
    this.direction = direction;
    setAddress({ direction });
    this.ask();
  }

  /** Rates the dimensions that sizing led to, with the forces, masses and strokes that hold. */
  rate(): void {
    const sized = Object.entries(this.answer?.sizing.dimensions ?? {}).flatMap(([name, value]) =>
      typeof value === 'number' && name !== 'p' && name !== 's'
        ? [[`dimensions.${name}`, value] as const]
        : [],
    );
    this.put({ ...this.entered, ...Object.fromEntries(sized) });
    this.turn('dimensions');
  }

  /** Fills in what the paper does not tell of a design from the one that it does. */
  async borrow(): Promise<void> {
    await app.try(async () => {
      const { dimensions } = await app.api.design({});
      const borrowed: Changes = {};
      for (const path of GROUPS.dimensions.flatMap(({ paths }) => paths)) {
        const value = numberIn({ dimensions }, path);
        if (value !== null && BORROWED.test(path)) borrowed[path] = value;
      }
      this.put({ ...borrowed, ...this.entered });
    });
  }
}

export const sizing = new Sizing('design');
