/** The steps of commissioning, as the server keeps them. */

import type { CommissioningRecord, CommissioningStatus } from '../../app/api/types';
import { control } from '../../app/drive/control.svelte';
import { app } from '../../app/store.svelte';
import { saveFile } from '../../ui/save-file';

const PERIOD = 500; // ms
const PATH = '/drive/commissioning';

type Step = CommissioningStatus['steps'][number];

class CommissioningSteps {
  now = $state.raw<CommissioningStatus | null>(null);

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

  async do(step: Step['name']): Promise<void> {
    const asked = { path: { step }, body: {}, ...control.lease };
    this.now = await app.api.json('post', `${PATH}/{step}`, asked);
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
    if (this.now) await this.take({ link: this.now.record.link, findings: {} });
  }

  private async take(body: CommissioningRecord): Promise<void> {
    this.now = await app.api.json('put', PATH, { ...control.lease, body });
  }
}

export const commissioning = new CommissioningSteps();
