import { describe, expect, it } from 'vitest';
import { drawAxes, valueTicks, withUnit } from './axes';
import { AxisScale } from './axis-scale';
import { recorder } from './recorder';

const scale = (from: number, to: number, unit: string, height: number) =>
  new AxisScale({ label: '', unit }, from, to, [height, 0]);
const texts = (ticks: readonly { text: string }[]) => ticks.map(({ text }) => text);

describe('values of an axis without a name', () => {
  it('are round, no nearer than a line of text, the unit at the last', () =>
    expect(texts(valueTicks(scale(-30e-6, 40e-6, 'm', 100)))).toEqual(['−20', '0', '20', '40 µm']));
  it('are both ends and zero where there is little room', () => {
    expect(texts(valueTicks(scale(-3, 4, 'N', 40)))).toEqual(['−3', '0', '4 N']);
    expect(texts(valueTicks(scale(-1, 4, 'N', 40)))).toEqual(['−1', '4 N']);
  });
  it('are round where the axis was zoomed or moved, whatever its height', () => {
    for (const height of [27, 40, 60, 130])
      for (const [from, to] of [
        [-35.7911e-6, 0.14015e-6],
        [-26.9034e-6, 3.0966e-6],
        [1.234567e-6, 9.87654e-6],
        [-7.7777e-6, 8.8888e-6],
      ] as const)
        for (const { value, text } of valueTicks(scale(from, to, 'm', height))) {
          expect(text.replace(/[^0-9]/g, '').length, text).toBeLessThanOrEqual(3);
          expect(value).toBeGreaterThanOrEqual(from);
          expect(value).toBeLessThanOrEqual(to);
        }
    expect(texts(valueTicks(scale(-35.7911e-6, 0.14015e-6, 'm', 27)))).toEqual(['−30', '0 µm']);
  });
  it('have as many decimals as tell neighbours apart', () =>
    expect(
      texts(withUnit(scale(0, 5, 'A', 100).named([0, 2.5, 5]), scale(0, 5, 'A', 100))),
    ).toEqual(['0.0', '2.5', '5.0 A']));
});

it('axes are drawn at whole pixels and a half, so that they are sharp', () => {
  const { canvas, calls } = recorder();
  const x = new AxisScale({ label: 'time', unit: 's' }, 1.3, 11.3, [50, 350]);
  const y = scale(0, 7, 'N', 200);
  drawAxes(canvas, x, y, { x: x.ticks(70), y: valueTicks(y) });
  const upright = calls.filter(([name, , py]) => name === 'moveTo' && py === 0);
  expect(upright.length).toBeGreaterThan(1);
  for (const [, px] of upright) expect((px as number) % 1).toBe(0.5);
});
