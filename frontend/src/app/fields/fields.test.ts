import { expect, it } from 'vitest';
import { editable, fieldOf, nameOf, needsRestart, ownerOf, refusal, show } from './fields.svelte';

it('shows gains as the paper prints them', () => {
  const path = 'variants.B.controller.x.k_p';
  expect(fieldOf(path)).toEqual({ label: 'k_p x', unit: 'N/mm', factor: 1e-3, whole: false });
  expect(show(path, 200300)).toBe('200.3');
  expect(ownerOf(path)).toBe('B');
});

it('shows every kind of value', () => {
  expect(show('plant.x.friction.enabled', false)).toBe('off');
  expect(show('plant', 'matched')).toBe('matched');
  expect(show('trajectory.lead_in', null)).toBe('auto');
  expect(show('plant.x.amplifiers.offset', [0.1, -0.1, 0.05])).toBe('0.1, −0.1, 0.05');
  expect(show('seed', 2019)).toBe('2019');
  expect(show('variants.B.controller.sharing.law', 'force-per-ampere')).toBe('force per ampere');
  expect(show('learnt', { laps: 12, places: [], x: 'AAAA', y: 'AAAA' })).toBe('12 laps');
  expect(show('learnt', { laps: 1 })).toBe('1 lap');
  expect([show('learnt', null), show('learnt', '12 laps')]).toEqual(['none', '12 laps']);
  expect(nameOf('variants.B.controller.y.notch.gain')).toBe('B notch gain y');
  expect(ownerOf('plant.y.mass')).toBe('plant y');
});

it('writes fields without noise of the change of unit', () => {
  expect(editable('trajectory.radius', 0.015)).toBe('15');
  expect(editable('plant.x.encoder.resolution', 50e-9)).toBe('50');
  expect(editable('trajectory.frequency', 1 / 3)).toBe('0.3333');
  expect(editable('load.x', -2)).toBe('-2');
  expect(editable('trajectory.lead_in', Number.NaN)).toBe('');
});

it('names what it does not know by its path', () => {
  expect(fieldOf('plant.x.stop_damping')).toEqual({
    label: 'x stop damping',
    unit: '',
    factor: 1,
    whole: false,
  });
});

it('tells the range in the unit of the screen', () => {
  const loc = 'variants.B.controller.x.k_p';
  expect(
    refusal({
      loc,
      message: 'is out of range',
      value: -5000,
      bounds: { minimum: 0, maximum: 1e9 },
      unit: 'N/m',
    }),
  ).toBe('Is out of range: −5 N/mm. Allowed: 0 to 1000000 N/mm.');
  expect(refusal({ loc: 'trajectory', message: 'too fast.', range: '', unit: '' })).toBe(
    'Too fast.',
  );
});

it('knows what needs a restart', () => {
  expect(['seed', 'trajectory', 'trajectory.radius'].every(needsRestart)).toBe(true);
  expect(
    ['plant', 'plant.x.mass', 'variants.B.controller.delay', 'load.x'].some(needsRestart),
  ).toBe(false);
});
