/** Names on the Tune screen. */

/** Summary of the request of a search or a map. */
export function describe(request: Record<string, unknown>): string {
  const { axis = 'both', objective = { rms: 1 }, scenario = 'circle' } = request;
  const name = typeof scenario === 'string' ? scenario : (scenario as { name: string }).name;
  const axes = axis === 'both' ? 'x, y' : (axis as string);
  return `${name} ${axes}: ${Object.keys(objective as object).join(' + ')}`;
}
