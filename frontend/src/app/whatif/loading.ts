/** What is loaded once, and not waited for too long: a network may stall. */
export class Loading<T> {
  readonly value: Promise<T>;
  private readonly late: Promise<null>;

  /** @param patience so long it is waited for, ms */
  constructor(load: () => Promise<T>, patience: number) {
    this.value = load();
    this.late = new Promise((resolve) => {
      if (Number.isFinite(patience)) setTimeout(resolve, patience, null);
    });
  }

  /** Returns it once it is there; null while it takes longer than the patience, counted from its start. */
  soon(): Promise<T | null> {
    return Promise.race([this.value, this.late]);
  }
}

/** So long what the page loads is waited for where a server can answer, ms. */
export const PATIENCE = 1000;
