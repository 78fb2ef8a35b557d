import { ApiError } from '../api/client';
import { nameOf, refusal } from '../tuning/fields';

/** Returns what went wrong, in the names and units of the screen where the server names fields. */
export function wordsOf(error: unknown): string {
  if (error instanceof ApiError && error.problem.errors.length > 0) {
    return error.problem.errors
      .map((field) => [nameOf(field.loc), refusal(field)].filter(Boolean).join(': '))
      .join('\n');
  }
  return error instanceof Error ? error.message : String(error);
}
