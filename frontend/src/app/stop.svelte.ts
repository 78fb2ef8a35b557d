/** STOP, sent again and again until the server has answered. */

import { ApiError } from './api/client';

/** One attempt may take this long, ms: a hanging one gives its connection back. */
const ATTEMPT = 2000;
/** Between two attempts, ms. */
const PAUSE = 500;
/** Without an answer for this long, ms, STOP counts as not sent. */
const NOTICE = 500;

export class RepeatedStop {
  /** Set from pressing STOP until it is answered. */
  pending = $state(false);
  /** Set while it is repeated, as nothing has answered. */
  unsent = $state(false);
  private going: Promise<void> | null = null;
  private attempt: AbortController | null = null;
  private hurried: () => void = () => undefined;

  /** `send` is called until it is answered; a refusal ends it too. */
  constructor(private readonly send: (signal: AbortSignal) => Promise<void>) {}

  /** Whether a failure leaves open if STOP was carried out. */
  static unanswered(error: unknown): boolean {
    return !(error instanceof ApiError) || error.transient || error.status >= 500;
  }

  /** Resolves with the answer; pressed again meanwhile, the next attempt comes at once. */
  press(): Promise<void> {
    this.hurry();
    this.going ??= this.repeat().finally(() => {
      this.going = null;
      this.pending = this.unsent = false;
    });
    return this.going;
  }

  /** Attempts at once, in place of one without an answer: the network may be back. */
  hurry(): void {
    if (this.unsent) this.attempt?.abort();
    this.hurried();
  }

  private async repeat(): Promise<void> {
    this.pending = true;
    const notice = setTimeout(() => (this.unsent = true), NOTICE);
    try {
      while (!(await this.answered())) {
        this.unsent = true;
        await new Promise<void>((resolve) => {
          this.hurried = resolve;
          setTimeout(resolve, PAUSE);
        });
      }
    } finally {
      clearTimeout(notice);
    }
  }

  private async answered(): Promise<boolean> {
    const attempt = new AbortController();
    this.attempt = attempt;
    const timer = setTimeout(() => attempt.abort(), ATTEMPT);
    try {
      await this.send(attempt.signal);
      return true;
    } catch (error) {
      if (RepeatedStop.unanswered(error)) return false;
      throw error;
    } finally {
      clearTimeout(timer);
    }
  }
}
