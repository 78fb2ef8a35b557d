import { describe, expect, it } from 'vitest';
import { columnsOf, differencesOf, SCOPES, scopeOf } from './scope-catalog';

const all = SCOPES.map(({ id }) => scopeOf(id, ['A', 'B'], 'B', 'x'));

describe('scopes', () => {
  it('tell B from A without colour', () => {
    const [a, b, difference] = all[0]?.traces ?? [];
    expect(difference?.dash).toBeDefined();
    expect([a?.marker, b?.marker]).toEqual([undefined, 'dot']);
  });
  it('need each column once, and nothing that is computed here', () => {
    const columns = columnsOf(all, ['A', 'B']);
    expect(new Set(columns).size).toBe(columns.length);
    expect(columns).toContain('B.x.current_a');
    expect(columns.some((column) => column.startsWith('A-B'))).toBe(false);
  });
  it('work with one variant', () => {
    const scope = scopeOf('ex', ['A'], 'A', 'x');
    expect(scope.traces.map((trace) => trace.column)).toEqual(['A.x.following_error']);
    expect(differencesOf(['A'])).toEqual([]);
  });
  it('compare both axes', () => {
    expect(differencesOf(['A', 'B']).map(({ name }) => name)).toEqual([
      'A-B.x.following_error',
      'A-B.y.following_error',
    ]);
  });
});
