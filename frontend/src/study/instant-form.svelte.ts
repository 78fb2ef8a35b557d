/** A study that is answered while its numbers change. */

import type { Changes, StudyKind } from '../app/api/types';
import { LatestWins } from '../app/latest-wins';
import { StudyForm } from './study-form.svelte';

/** Time without another number before the server is asked, ms. */
const PAUSE = 60;

export abstract class InstantForm<A> extends StudyForm {
  answer = $state.raw<A | null>(null);
  /** Whether the answer is of what the form says. */
  fresh = $state(false);
  /** Whether there is nothing to show because the server refused or did not answer. */
  readonly failed = $derived.by(
    () => this.answer === null && Object.keys(this.problems).length > 0,
  );
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly queue = new LatestWins<null>(() => this.run());

  constructor(kind: StudyKind, initial: Changes = {}) {
    super(kind, initial);
  }

  /** Answers what the form says; null where a newer question waits. */
  protected abstract request(): Promise<A | null>;

  protected get superseded(): boolean {
    return this.queue.superseded;
  }

  override put(entered: Changes): void {
    super.put(entered);
    this.ask();
  }

  /** Takes what is entered without asking. */
  protected keep(entered: Changes): void {
    super.put(entered);
  }

  ask(): void {
    this.fresh = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.queue.push(null), PAUSE);
  }

  /** Shows an answer that was not asked for by the form. */
  protected show(answer: A): void {
    this.answer = answer;
    this.problems = {};
    this.fresh = !this.superseded;
  }

  private async run(): Promise<void> {
    try {
      const answer = await this.request();
      if (answer !== null) this.show(answer);
    } catch (error) {
      this.refuse(error);
    }
  }
}
