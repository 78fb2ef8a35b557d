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
