/** What is wrong with the values in the page's fields, by path. */

import { without } from '../api/scenario-paths';
import type { ProblemField } from '../api/types';
import { messages } from '../messages.svelte';
import { refusal } from './fields.svelte';

export class Refusals {
  /** Messages of values that the server refused. */
  problems = $state.raw<Record<string, string>>({});
  /** What stands in fields and is no number; empty while it is typed. */
  mistyped = $state.raw<Record<string, string>>({});

  /** Takes what the server says of fields; what names none becomes a message. */
  take(fields: readonly ProblemField[], detail: string): void {
    this.problems = Object.fromEntries(fields.map((field) => [field.loc, refusal(field)]));
    if (fields.length === 0 && detail !== '') messages.error(detail);
  }

  /** Forgets what was said of values that are being replaced, or of all. */
  clear(paths?: readonly string[]): void {
    this.problems = paths ? without(this.problems, paths) : {};
  }

  /** Takes what stands in a field in place of its value; null when it is gone. */
  mistype(path: string, text: string | null): void {
    const others = without(this.mistyped, [path]);
    this.mistyped = text === null ? others : { ...others, [path]: text };
  }
}
