import { describe, expect, it, vi } from 'vitest';
import { formula } from '../../ui/units';
import { nested } from '../../study/study-form.svelte';
import { computed, numberIn } from './quantity-fields';
import { section } from './sizing/cross-section';
import { differs, withTooth } from './sizing/sizing-fields';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

it('dotted paths become tables and are read back', () => {
  const table = nested({ 'dimensions.x.mass': 5, 'dimensions.N': 145 });
  expect(table).toEqual({ dimensions: { x: { mass: 5 }, N: 145 } });
  expect(numberIn(table, 'dimensions.x.mass')).toBe(5);
  expect(numberIn(table, 'dimensions.y.mass')).toBeNull();
});

it('of tooth, slot and ratio the last one typed holds', () => {
  const first = withTooth({ 'requirements.tau': 8e-3 }, 'requirements.p', 3e-3);
  expect(withTooth(first, 'requirements.sigma', 1)).toEqual({
    'requirements.tau': 8e-3,
    'requirements.sigma': 1,
  });
});

it('writes formulas and numbers as people do', () => {
  expect(formula('w = limbs n tau - s')).toBe('w = limbs n τ − s');
  expect(formula('2 g B_g/mu_0')).toBe('2 g B_g/μ_0');
  expect(computed(0.000228418, 'm^2')).toEqual({ number: '228.4', unit: 'mm²' });
  expect(computed(145, '1')).toEqual({ number: '145', unit: '' });
  expect(computed(36616.16, 'A/m')).toEqual({ number: '36.62', unit: 'kA/m' });
  expect(computed(0.8435, 'm/s')).toEqual({ number: '0.8435', unit: 'm/s' });
  expect(computed(null, 'N').number).toBe('–');
});

describe('the drawing', () => {
  const teeth = { tau: 7.2e-3, p: 3.6e-3, s: 3.6e-3, n: 3, limbs: 2, g: 0.3e-3 };

  it('is as wide as the mover, with all of its teeth inside', () => {
    const { w, teeth: boxes } = section(teeth);
    expect(w).toBeCloseTo(39.6e-3, 9);
    expect(boxes).toHaveLength(6);
    const last = boxes[5];
    expect((last?.x ?? 0) + (last?.width ?? 0)).toBeCloseTo(w, 9);
  });

  it('leaves the gap between mover and stator', () => {
    const { stator, back } = section(teeth);
    expect(stator.length).toBeGreaterThan(6);
    for (const { x, y, width } of stator) {
      expect(y).toBe(teeth.g);
      expect(width).toBeGreaterThan(0);
      expect(x + width).toBeLessThanOrEqual(back.x + back.width + 1e-12);
    }
  });

  it('keeps the coils of two limbs apart', () => {
    const [left, right] = section({ ...teeth, n: 1 }).coils;
    expect((left?.x ?? 0) + (left?.width ?? 0)).toBeLessThan(right?.x ?? 0);
  });
});

it('a printed number differs only beyond its last digit', () => {
  const reading = {
    quantity: '',
    equation: '',
    unit: 'm/s',
    remark: '',
    printed_form: 'a number without formula',
    used_form: 'sqrt(f stroke/M)',
  };
  expect(differs({ ...reading, printed_value: 1.01, value: 1.0085 })).toBe(false);
  expect(differs({ ...reading, printed_value: 0.89, value: 0.8435 })).toBe(true);
  expect(differs({ ...reading, printed_form: '', printed_value: null, value: 1 })).toBe(false);
});
