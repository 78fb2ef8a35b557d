/** The steps of commissioning, as the server keeps them. */

import type { CommissioningRecord, CommissioningStatus } from '../../app/api/types';
import { control } from '../../app/drive/control.svelte';
import { app } from '../../app/store.svelte';
import { saveFile } from '../../ui/export';

const PERIOD = 500; // ms
const PATH = '/drive/commissioning';

export type Step = CommissioningStatus['steps'][number];
export type Finding = NonNullable<Step['finding']>;
export type Figure = NonNullable<Finding['rows']>[number];
export type Change = NonNullable<CommissioningRecord['taken']>[number];

class CommissioningSteps {
  now = $state.raw<CommissioningStatus | null>(null);
  readonly done = $derived(this.now?.steps.filter(({ state }) => state === 'done').length ?? 0);
  /** Changes in effect: none of those that were taken on other drives. */
  readonly taken = $derived(this.now?.other_drives === '' ? (this.now.record.taken ?? []) : []);
  /** Why the document is not of the drives that are there, in a sentence; empty when it is. */
  readonly others = $derived.by(() => {
    const text = this.now?.other_drives ?? '';
    return text && `${text.charAt(0).toUpperCase()}${text.slice(1)}.`;
  });
  /** Whether the document holds anything, of these drives or of others. */
  readonly kept = $derived(
    Object.keys(this.now?.record.findings ?? {}).length > 0 || !!this.now?.record.taken?.length,
  );

  /** Asks twice a second until the returned function is called. */
  follow(): () => void {
    const ask = () =>
      void app.api.json('get', PATH, {}).then(
        (answer) => (this.now = answer),
        () => undefined, // the headline says that the server is silent
      );
    ask();
    const timer = setInterval(() => !document.hidden && ask(), PERIOD);
    return () => clearInterval(timer);
  }

  /** Does a step; one with torque has to be confirmed, and only begins. */
  async do(step: Step['name'], body: { confirm?: true } = {}): Promise<void> {
    const request = { path: { step }, ...control.lease, body };
    this.now = await app.api.json('post', `${PATH}/{step}`, request);
  }

  /** Takes the changes that a step shows; the link is brought up anew with them. */
  async takeChanges(step: Step['name'], body: Change[]): Promise<void> {
    const request = { path: { step }, ...control.lease, body };
    this.now = await app.api.json('post', `${PATH}/{step}/changes`, request);
    app.drive.take(await app.api.json('get', '/drive', {})); // which is no longer ready
  }

  /** Downloads what was found. */
  save(): void {
    if (!this.now) return;
    const text = JSON.stringify(this.now.record, null, 2);
    saveFile('commissioning.json', 'application/json', text);
  }

  async load(file: File): Promise<void> {
    await this.take(JSON.parse(await file.text()) as CommissioningRecord);
  }

  async startOver(): Promise<void> {
    if (this.now)
      await this.take({ link: this.now.record.link, findings: {}, taken: [], seal: '' });
  }

  private async take(body: CommissioningRecord): Promise<void> {
    this.now = await app.api.json('put', PATH, { ...control.lease, body });
  }
}

export const commissioning = new CommissioningSteps();
