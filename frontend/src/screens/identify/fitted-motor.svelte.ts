/** The simulated motor with what was identified, saved as a motor of one's own. */

import type { Axis, Motor, MotorEntry } from '../../app/api/types';
import { getRun } from '../../parts/runs/runs-api';
import { errorOf, simulateRun } from '../../parts/runs/simulate-run';
import { SavedDocuments } from '../../parts/saved/saved-documents.svelte';
import { screen } from '../../app/screen.svelte';
import { app } from '../../app/store.svelte';
import { quantity } from '../../ui/units';

/** What simulations before and after the fit leave of an axis's following error, in words. */
export interface ResidualRow {
  axis: Axis;
  before: string;
  after: string;
}

export function residualRows(motor: Motor): readonly ResidualRow[] {
  const residual = motor.origin?.residual ?? {};
  return Object.entries(residual).map(([axis, { before, after }]) => ({
    axis: axis as Axis,
    before: text(before),
    after: text(after),
  }));
}

function text(metres: number): string {
  const { number, unit } = quantity(metres, 'm');
  return `${number} ${unit}`;
}

/** Returns a motor's name of what was typed: small letters, digits and hyphens. */
export function motorName(typed: string): string {
  return typed
    .toLowerCase()
    .replace(/[^a-z0-9]+/g, '-')
    .replace(/^-+|-+$/g, '')
    .slice(0, 64);
}

class FittedMotor {
  /** Name that is typed for it. */
  typed = $state('');
  busy = $state(false);
  /** The motor that was saved last, and under which name. */
  private kept = $state.raw<{ motor: Motor; name: string } | null>(null);
  readonly motors = new SavedDocuments<MotorEntry, Motor>({
    noun: 'motor',
    list: app.api.motors,
    drop: app.api.dropMotor,
    put: app.api.keepMotor,
    read: async ({ name }) => {
      const { plant, origin = null } = await app.api.motor(name);
      return { plant, origin };
    },
    nameOf: motorName,
    changed: async (name, formerly) => {
      if (this.kept && this.kept.name === formerly) this.kept = { ...this.kept, name };
      await app.catalogue.motorChanged(name);
    },
  });

  /** Name under which a motor is kept; empty where it is not. */
  nameOf(motor: Motor): string {
    if (this.kept?.motor !== motor || !this.motors.has(this.kept.name)) return '';
    return this.kept.name;
  }

  async save(motor: Motor, name: string): Promise<void> {
    if (await this.motors.save(name, motor, this.nameOf(motor))) this.kept = { motor, name };
  }

  /** Simulates the run with a motor, and opens both in Compare. */
  simulate = (id: string, name: string) =>
    this.carryOut(async () => {
      const run = await getRun(id);
      const made = await simulateRun(run, name);
      if (made === null) return;
      screen.go('runs', { run: `${made},${id}`, compare: '{}', channel: errorOf(run) });
    });

  private async carryOut(work: () => Promise<void>): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    await app.try(work);
    this.busy = false;
  }
}

export const fitted = new FittedMotor();
