import { expect, it } from 'vitest';
import { readPreview } from './preview';

function answer(): ArrayBuffer {
  const header = {
    result: { window: { start: 4.5, end: 10.5 }, variants: {} },
    how: 'whole',
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
  const { result, how, source } = readPreview(answer());
  expect(result.window.end).toBe(10.5);
  expect(how).toBe('whole');
  expect([source.start, source.step, source.last]).toEqual([4.5, 3, 2]);
  expect(source.at('A.x.following_error', 8)).toBe(3);
  expect(source.at('A.x.following_error', 11)).toBeNaN();
});

it('computes A less B', () => {
  const { source } = readPreview(answer());
  expect(source.at('A-B.x.following_error', 4.6)).toBe(1.5);
  const [low, high] = [new Float32Array(1), new Float32Array(1)];
  const bins = source.cut(4.5, 10.5, 1);
  source.reduce('A-B.x.following_error', bins, low, high);
  expect([low[0], high[0]]).toEqual([1.5, 2.5]);
});
