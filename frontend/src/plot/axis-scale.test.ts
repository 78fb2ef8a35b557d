import { describe, expect, it } from 'vitest';
import { AxisScale, ends, equalise, extent } from './axis-scale';

const texts = (scale: AxisScale, apart = 70) =>
  scale.ticks(apart).flatMap(({ text }) => (text === '' ? [] : [text]));

describe('ends of an axis', () => {
  it('begin at zero where the data have one sign and begin near it', () => {
    expect(ends({ label: 'f' }, { low: 2, high: 100 })[0]).toBe(0);
    expect(ends({ label: 'f' }, { low: 60, high: 100 })[0]).toBeCloseTo(58);
  });

  it('take what is given, and give a constant room', () => {
    expect(ends({ label: 'f', from: -3, to: 7 }, { low: 0, high: 1 })).toEqual([-3, 7]);
    expect(ends({ label: 'f' }, { low: 4, high: 4 })).toEqual([3, 5]);
  });

  it('stay positive on a logarithmic axis', () => {
    const range = extent([0, -4, null, Number.NaN, 3, 300], true);
    expect(range).toEqual({ low: 3, high: 300 });
    expect(ends({ label: 'k', log: true, from: 0 }, range)[0]).toBeGreaterThan(0);
  });
});

describe('an axis', () => {
  it('keeps a unit that it is given, in its ticks and in what is read off', () => {
    const axis = { label: 'k_p', unit: 'N/m', log: true, scale: { factor: 1e-3, unit: 'N/mm' } };
    const scale = new AxisScale(axis, 1e4, 1e6, [0, 200]);
    expect(texts(scale)).toEqual(['10', '100', '1000']);
    expect(scale.read(4.2e6)).toEqual({ number: '4200', unit: 'N/mm' });
  });

  it('takes the prefix with which its values read between 1 and 1000', () => {
    const scale = new AxisScale({ label: 'error', unit: 'm' }, -20e-6, 20e-6, [0, 300]);
    expect(scale.shown.unit).toBe('µm');
    expect(texts(scale)).toEqual(['−20', '−10', '0', '10', '20']);
    expect(scale.text(3.14159e-6)).toBe('3.14');
  });

  it('is the same there and back', () => {
    for (const log of [false, true]) {
      const scale = new AxisScale({ label: 'k', log }, 2, 5000, [400, 8]);
      expect(scale.at(scale.px(123))).toBeCloseTo(123, 9);
      expect(scale.px(2)).toBeCloseTo(400);
      expect(scale.px(5000)).toBeCloseTo(8);
    }
  });

  it('names decades where there are many, and 1, 2, 5 where there are few', () => {
    const many = new AxisScale({ label: 'f', unit: 'Hz', log: true }, 0.1, 1000, [0, 400]);
    expect(texts(many)).toEqual(['0.1', '1', '10', '100', '1000']);
    const few = new AxisScale({ label: 'f', unit: 'Hz', log: true }, 1, 20, [0, 400]);
    expect(texts(few)).toEqual(['1', '2', '5', '10', '20']);
    const less = new AxisScale({ label: 'f', unit: 'Hz', log: true }, 20, 40, [0, 400]);
    expect(texts(less)).toEqual(['20', '25', '30', '35', '40']);
  });

  it('has no place for what a logarithm does not take', () => {
    const scale = new AxisScale({ label: 'k', log: true }, 1, 10, [0, 100]);
    expect(scale.px(0)).toBeNaN();
    expect(scale.px(null)).toBeNaN();
  });
});

it('equal axes have units of one length', () => {
  const { x, y } = equalise([0, 1], [0, 1], 400, 200);
  expect((x[1] - x[0]) / 400).toBeCloseTo((y[1] - y[0]) / 200);
  expect(y).toEqual([0, 1]);
});
