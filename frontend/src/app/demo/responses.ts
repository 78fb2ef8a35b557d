/** Answers of a demo, as the server's are. */

import type { Problem } from '../api/types';
import { Beyond } from '../whatif/changed-lanes';
import { Refused } from '../whatif/refused-changes';
import { NEEDS_SERVER } from './demo-mode';

const JSON_TYPE = { 'Content-Type': 'application/json' };

export function json(value: unknown): Response {
  return new Response(JSON.stringify(value), { headers: JSON_TYPE });
}

export function problem(
  status: number,
  detail: string,
  errors: Problem['errors'] | readonly object[] = [],
): Response {
  const title = status === 422 ? 'Refused' : 'No server';
  return new Response(JSON.stringify({ title, status, detail, errors }), {
    status,
    headers: JSON_TYPE,
  });
}

/** Says what is refused, and what takes a server; any other error is thrown on. */
export function refusal(error: unknown): Response {
  if (error instanceof Refused) return problem(422, error.message, error.problem.errors);
  if (error instanceof Beyond) return problem(501, `${error.message}. ${NEEDS_SERVER}`);
  throw error;
}
