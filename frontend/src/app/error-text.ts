import { ApiError, UNREACHABLE } from './api/client';
import type { ProblemField } from './api/types';
import { nameOf, refusal } from './fields/fields.svelte';

/** Returns what went wrong, in the names and units of the screen where the server names fields. */
export function errorText(error: unknown): string {
  if (error instanceof ApiError && error.problem.errors.length > 0) {
    return fieldErrorsText(error.problem.errors);
  }
  return error instanceof Error ? error.message : String(error);
}

/** Returns why a command failed: one without an answer may still be carried out, but is not repeated. */
export function commandText(command: string, error: unknown): string {
  const text = errorText(error);
  if (!(error instanceof ApiError) || error.status !== UNREACHABLE) return text;
  return `${command} was not answered, and is not sent again. ${text}`;
}

/** Returns why a capture of a session was not kept: in seconds, and not in ticks. */
export function captureErrorText(error: unknown): string {
  const fields = error instanceof ApiError ? error.problem.errors : [];
  const gone = fields.find(({ loc, message }) => loc === 'from_tick' && message.includes('gone'));
  return gone ? `This capture cannot be kept: ${gone.message}.` : errorText(error);
}

/** Returns what is wrong with fields, a line each. */
export function fieldErrorsText(fields: readonly ProblemField[]): string {
  return fields
    .map((field) => [nameOf(field.loc), refusal(field)].filter(Boolean).join(': '))
    .join('\n');
}

/** Returns why a scenario file was not opened. */
export function fileErrorText(name: string, error: unknown): string {
  const fields = error instanceof ApiError ? error.problem.errors : [];
  const [unread] = fields.filter(({ loc }) => loc === 'body');
  if (!unread) {
    return `${name} was not opened.${fields.length > 0 ? '\n' : ' '}${errorText(error)}`;
  }
  return `${name} cannot be read: it ${unread.message}.`;
}
