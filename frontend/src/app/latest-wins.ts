/**
 * One job at a time, or a few, and of those that wait only the newest: a slider's request while an
 * answer is on its way replaces the one before.
 */
export class LatestWins<T> {
  private running = 0;
  private waiting: { value: T } | null = null;
  private idlers: (() => void)[] = [];

  constructor(
    private readonly job: (value: T) => Promise<void>,
    /** Jobs that run at once; they may end in another order than they began. */
    private readonly atOnce = 1,
  ) {}

  /** Whether a job runs or waits. */
  get busy(): boolean {
    return this.running > 0;
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
    if (this.running < this.atOnce) void this.work();
  }

  private async work(): Promise<void> {
    this.running += 1;
    while (this.waiting) {
      const { value } = this.waiting;
      this.waiting = null;
      // A job handles its own failures; one that does not must not stop those after it.
      await this.job(value).catch(console.error);
    }
    this.running -= 1;
    if (this.busy) return;
    for (const resolve of this.idlers.splice(0)) resolve();
  }
}

/** The order of questions, for answers that may come in another one. */
export class Turns {
  private asked = 0;
  private shown = 0;

  /** Returns the turn of a new question. */
  next(): number {
    this.asked += 1;
    return this.asked;
  }

  /** Whether the answer to a question is to be shown: not once that to a later one was. */
  take(turn: number): boolean {
    if (turn < this.shown) return false;
    this.shown = turn;
    return true;
  }
}
