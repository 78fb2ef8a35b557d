/**
 * One job at a time, and of those that wait only the newest: what a slider asks for while an answer
 * is on its way replaces what it asked before.
 */
export class Newest<T> {
  private running = false;
  private waiting: { value: T } | null = null;

  constructor(private readonly job: (value: T) => Promise<void>) {}

  /** Whether a job runs or waits. */
  get busy(): boolean {
    return this.running;
  }

  /** Whether something newer waits behind the job that runs. */
  get superseded(): boolean {
    return this.waiting !== null;
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
  }
}
