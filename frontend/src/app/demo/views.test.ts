import { describe, expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/demo-views.json';
import { circularTest, type Recorded } from './circular-test';
import { spectrumDocument, type SpectrumRequest } from './spectrum';

/** Compares numbers by their size, and everything else exactly. */
function expectClose(actual: unknown, expected: unknown, tolerance: number, path = ''): void {
  if (typeof expected === 'number' && typeof actual === 'number') {
    const off = Math.abs(actual - expected);
    expect(off, `${path}: ${actual}, ${expected}`).toBeLessThanOrEqual(
      tolerance * Math.abs(expected) + 2e-12,
    );
  } else if (expected !== null && typeof expected === 'object') {
    expect(Object.keys(actual as object).sort(), path).toEqual(Object.keys(expected).sort());
    for (const [key, value] of Object.entries(expected)) {
      expectClose((actual as Record<string, unknown>)[key], value, tolerance, `${path}.${key}`);
    }
  } else expect(actual, path).toBe(expected);
}

describe('a spectrum in the page', () => {
  it.each(fixture.spectra)('is the server’s with $options', ({ options, document }) => {
    const columns = [{ name: 'A.x.following_error', unit: 'm', values: fixture.samples }];
    const request = { ...options, period: document.period, columns } as SpectrumRequest;
    const [own] = spectrumDocument(request).columns;
    const [expected] = document.columns;
    // Densities are of the order of 1e-18.
    const scaled = (column: object) =>
      JSON.parse(
        JSON.stringify({ ...column, note: '' }, (_, value: unknown) =>
          typeof value === 'number' ? 1e20 * value : value,
        ),
      ) as object;
    expect(own?.peaks.length).toBeGreaterThan(0);
    expectClose(scaled(own as object), scaled(expected as object), 2e-5);
  });

  it('needs 64 samples', () => {
    const columns = [{ name: 'u', unit: '1', values: fixture.samples.slice(21, 84) }];
    expect(() => spectrumDocument({ period: 1, columns, averages: 1 })).toThrow('64');
  });
});

describe('a ballbar test in the page', () => {
  const recorded = (way: 'ccw' | 'cw'): Recorded => {
    const { x, y, error_x, error_y } = fixture.recordings[way];
    const errors = { A: [Float64Array.from(error_x), Float64Array.from(error_y)] as const };
    const [own, other] = [Float64Array.from(x), Float64Array.from(y)];
    return { period: 5e-4, x: own, y: other, errors, counts: [50e-9, 50e-9] };
  };

  it('is the server’s, with the other direction simulated', async () => {
    const own = await circularTest(recorded('ccw'), ['A'], async (way) => recorded(way as 'cw'));
    expectClose(own, fixture.ballbar, 1e-9);
    expect(own.variants['A']?.directions['ccw']?.quadrants).not.toContain(null);
  });

  it('leaves out what has diverged', async () => {
    const one = recorded('ccw');
    one.errors['A']?.[0].fill(Number.NaN, 300);
    const own = await circularTest(one, ['A'], async () => 'no');
    expect(own.variants['A']).toEqual({ directions: {}, both: null });
    expect(own.note).toContain('no');
  });

  it('needs a circle, and a lap of it', async () => {
    const one = recorded('ccw');
    const line = { ...one, y: one.x };
    await expect(circularTest(line, ['A'], async () => '')).rejects.toThrow('no circle');
    const part = { ...one, x: one.x.slice(0, 200), y: one.y.slice(0, 200) };
    await expect(circularTest(part, ['A'], async () => '')).rejects.toThrow('no whole lap');
  });
});
