/**
 * One job at a time, and of those that wait only the newest: a slider's request while an answer is
 * on its way replaces the one before.
 */
export class LatestWins<T> {
  private running = false;
  private waiting: { value: T } | null = null;
  private idlers: (() => void)[] = [];

  constructor(private readonly job: (value: T) => Promise<void>) {}

  /** Whether a job runs or waits. */
  get busy(): boolean {
    return this.running;
  }

  /** Whether something newer waits behind the job that runs. */
  get superseded(): boolean {
    return this.waiting !== null;
  }

  /** Resolves when no job runs or waits. */
  idle(): Promise<void> {
    if (!this.busy) return Promise.resolve();
    return new Promise((resolve) => this.idlers.push(resolve));
  }

  push(value: T): void {
    this.waiting = { value };
    if (!this.running) void this.work();
  }

  private async work(): Promise<void> {
    this.running = true;
    while (this.waiting) {
      const { value } = this.waiting;
      this.waiting = null;
      // A job handles its own failures; one that does not must not stop those after it.
      await this.job(value).catch(console.error);
    }
    this.running = false;
    for (const resolve of this.idlers.splice(0)) resolve();
  }
}
