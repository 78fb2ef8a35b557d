/** The run that lists compare with, if one is chosen: kept in the address and by this browser. */

import type { Run } from '../../app/api/types';
import { fromAddress, load, save, setAddress } from '../../app/storage';
import { getRun } from '../../parts/runs/runs-api';

const KEY = 'runs.baseline';

class Baseline {
  id = $state(fromAddress('baseline') ?? load(KEY, ''));
  run = $state.raw<Run | null>(null);

  /** Takes what the address says, and reads the run. */
  readAddress(): void {
    const address = fromAddress('baseline');
    if (address !== null && address !== '') this.id = address;
    setAddress({ baseline: this.id });
    void this.read();
  }

  /** Makes a run the baseline; for the one that is, clears it. */
  toggle(run: Run): void {
    const id = run.id === this.id ? '' : run.id;
    this.id = id;
    this.run = id === '' ? null : run;
    save(KEY, id);
    setAddress({ baseline: id });
  }

  private async read(): Promise<void> {
    const { id } = this;
    if (id === '' || this.run?.id === id) return;
    try {
      const run = await getRun(id);
      if (this.id === id && run.deleted === null) this.run = run;
    } catch {
      // It is gone or out of reach: the list stays as it is without a baseline.
    }
  }
}

export const baseline = new Baseline();
