/** A run as something to paste elsewhere, which gives the same numbers there. */

import type { RunDetail } from '../../app/api/types';

/** Beyond these the server lists no more differences. */
const LISTED = 50;
/** Fields that decide what their neighbours mean: those are not listed then. */
const NAMED = /(^|\.)(kind|name|law)$|^trajectory$/;
const PLAIN = /^[A-Za-z0-9_.-]+$/;

export type Form = 'CLI' | 'curl' | 'Python' | 'TOML';
type Scalar = string | number | boolean;

/**
 * Returns the differences from the shipped scenario as they can be set one by one; null where that
 * would not be all of the run: it was changed while it ran, or has another part.
 */
function settings(run: RunDetail, shipped: readonly string[]): [string, Scalar][] | null {
  const { differences, scenario } = run;
  if (!shipped.includes(scenario) || differences.length >= LISTED) return null;
  const leaves: [string, Scalar][] = [];
  for (const { path, value, shipped: before } of differences) {
    const scalar = ['number', 'boolean'].includes(typeof value) || isPlain(value);
    if (!scalar || before === null || NAMED.test(path)) return null;
    leaves.push([path, value as Scalar]);
  }
  return leaves;
}

function isPlain(value: unknown): boolean {
  return typeof value === 'string' && PLAIN.test(value);
}

/**
 * Returns the ways in which a run can be made again. Of a live session or a measurement there are
 * none, of a scenario of its own those that take the whole of it.
 */
export function commandsOf(
  run: RunDetail,
  origin: string,
  shipped: readonly string[],
): Partial<Record<Form, string>> {
  if (run.kind !== 'simulation' || !run.scenario_document) return {};
  const set = settings(run, shipped);
  const simulate = `${origin}/api/v1/simulate`;
  if (!set) {
    const lines = [
      'import json, urllib.request as web',
      `run = json.load(web.urlopen("${origin}/api/v1/runs/${run.id}"))`,
      'body = json.dumps({"scenario": run["scenario_document"]}).encode()',
      `request = web.Request("${simulate}", body, {"Content-Type": "application/json"})`,
      'print(json.dumps(json.load(web.urlopen(request))["variants"], indent=2))',
    ];
    return { Python: lines.join('\n') };
  }
  const body = JSON.stringify({ scenario: run.scenario, set: Object.fromEntries(set) });
  const sets = set.map(([path, value]) => ` --set ${path}=${value}`).join('');
  const python = [
    'import json, urllib.request as web',
    `body = ${JSON.stringify(body)}.encode()`,
    `request = web.Request("${simulate}", body, {"Content-Type": "application/json"})`,
    'print(json.dumps(json.load(web.urlopen(request))["variants"], indent=2))',
  ];
  const toml = [
    `base = "${run.scenario}"`,
    ...set.map(([path, value]) => `${path} = ${JSON.stringify(value)}`),
  ];
  return {
    CLI: `motionlab run ${run.scenario}${sets}`,
    curl: `curl -s -H 'Content-Type: application/json' -d '${body}' ${simulate}`,
    Python: python.join('\n'),
    TOML: `${toml.join('\n')}\n`,
  };
}

/** Says why a run has no such ways; empty where it may have. */
export function withoutCommands({ kind }: Pick<RunDetail, 'kind'>): string {
  if (kind === 'live') return 'no command repeats what was done in a live session';
  if (kind === 'drive')
    return 'motionlab drive run moves the drives again, never bit for bit alike';
  return kind === 'measurement' ? 'a measurement is not simulated' : '';
}

/** Returns the address that opens a run, or several, in any browser that reaches the server. */
export function linkTo(ids: readonly string[], { origin, pathname }: URL | Location): string {
  return `${origin}${pathname}?screen=runs&run=${ids.join()}`;
}
