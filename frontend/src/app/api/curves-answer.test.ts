import { expect, it } from 'vitest';
import fixture from '../../../../tests/fixtures/whatif.bin?inline';
import { readAnswer } from './curves-answer';

function answer(): ArrayBuffer {
  const header = {
    result: { window: { start: 4.5, end: 10.5 }, variants: {} },
    how: 'window',
    begin: 1.5,
    time: { start: 4.5, step: 3, count: 2 },
    columns: [
      { name: 'A.x.following_error', unit: 'm', minimum: 0, maximum: 2 },
      { name: 'B.x.following_error', unit: 'm', minimum: 4, maximum: 6 },
    ],
  };
  let text = JSON.stringify(header);
  while ((8 + text.length) % 8 !== 0) text += ' ';
  const bytes = new TextEncoder().encode(text);
  const buffer = new ArrayBuffer(8 + bytes.length + 8 * 4);
  new DataView(buffer).setUint32(0, bytes.length, true);
  new Uint8Array(buffer, 8).set(bytes);
  new Float32Array(buffer, 8 + bytes.length).set([1, 2, 3, 4, 0, 0, 1, 1]);
  return buffer;
}

it('reads result and curves', () => {
  const { result, how, begin, source } = readAnswer(answer());
  expect(result.window.end).toBe(10.5);
  expect([how, begin]).toEqual(['window', 1.5]);
  expect([source.start, source.step, source.last]).toEqual([4.5, 3, 2]);
  expect(source.at('A.x.following_error', 8)).toBe(3);
  expect(source.at('A.x.following_error', 11)).toBeNaN();
});

it('computes A less B', () => {
  const { source } = readAnswer(answer());
  expect(source.at('A-B.x.following_error', 4.6)).toBe(1.5);
  const [low, high] = [new Float32Array(1), new Float32Array(1)];
  const bins = source.cut(4.5, 10.5, 1);
  source.reduce('A-B.x.following_error', bins, low, high);
  expect([low[0], high[0]]).toEqual([1.5, 2.5]);
});

it('reads the fixture as tests/project/test_generated.py does', async () => {
  const data = await (await fetch(fixture)).arrayBuffer();
  const { result, how, begin, source } = readAnswer(data);
  expect([how, begin]).toEqual(['whole', 0]);
  expect(result.window).toEqual({ start: 0, end: 0.02 });
  expect(Object.keys(result.variants)).toEqual(['A', 'B']);
  expect([source.start, source.step, source.last]).toEqual([0, 0.001, 20]);
  const reduced = (column: string, bin: number) => {
    const [low, high] = [new Float32Array(1), new Float32Array(1)];
    source.reduce(column, { ...source.cut(0, 0, 1), first: bin, size: 1, count: 1 }, low, high);
    return [low[0], high[0]];
  };
  // Bin 19 holds ticks 38 and 39; the reference is 0.01 m/s (t - 5 ms) by then.
  const last = {
    'x.position_reference': [1.4e-4, 1.45e-4],
    'A.x.following_error': [3.145e-5, 3.225e-5],
    'B.x.following_error': [9.6e-6, 1.065e-5],
  };
  for (const [column, [low, high]] of Object.entries(last)) {
    const [least, most] = reduced(column, 19);
    expect(least).toBeCloseTo(low as number, 10);
    expect(most).toBeCloseTo(high as number, 10);
    expect(reduced(column, 0)[0]).toBe(0);
  }
});
