import { expect, test } from 'vitest';
import { type Range, StillSource } from '../../plot/source';
import { Trigger, type Watched } from './trigger.svelte';

const STEP = 5e-4;
const VELOCITY = 'x.velocity_reference';

/** A record of two seconds whose velocity turns four times, read as late as the test wants. */
class Record implements Watched {
  readonly columns = ['A.x.following_error'];
  readonly known = [{ name: VELOCITY, unit: 'm/s' }];
  readonly extent = { from: 0, to: 2 };
  readonly period = STEP;
  readonly moments = [];
  readonly coming = null;
  range: Range = this.extent;
  reading = Promise.resolve();

  async samples(_: readonly string[], range: Range): Promise<StillSource> {
    await this.reading;
    const count = Math.round((range.to - range.from) / STEP);
    const values = Float32Array.from({ length: count }, (_, i) =>
      Math.cos(2 * Math.PI * (range.from + (i + 0.5) * STEP)),
    );
    const columns = new Map([[VELOCITY, { minimum: values, maximum: values }]]);
    return new StillSource(range.from, STEP, count, columns);
  }

  look(range: Range | null): void {
    this.range = range ?? this.extent;
  }
}

async function settled(trigger: Trigger): Promise<void> {
  for (let i = 0; i < 100 && trigger.phase === 'searching'; i++) await Promise.resolve();
  expect(trigger.phase).toBe('done');
}

test('a record that is renewed twice while it is searched is searched whole', async () => {
  const view = new Record();
  const trigger = new Trigger(view);
  trigger.arm();
  await settled(trigger);
  expect(trigger.hitCount).toBe(4);
  expect(view.range).toEqual(trigger.captures[0]?.range);
  trigger.renew();
  trigger.renew();
  await settled(trigger);
  expect(trigger.hitCount).toBe(4);
});

test('what a person zooms to is what is searched next, and is seen again after Off', async () => {
  const view = new Record();
  const trigger = new Trigger(view);
  trigger.arm();
  await settled(trigger);
  view.look({ from: 0.4, to: 0.9 });
  trigger.arm();
  await settled(trigger);
  expect(trigger.hitCount).toBe(1);
  trigger.stop();
  expect(view.range).toEqual({ from: 0.4, to: 0.9 });
});
