import { describe, expect, it } from 'vitest';
import type { PlatformDocument } from '../../../app/api/types';
import { bodyOf, platformField, platformFields, shared, valueIn } from './platform-fields';

const ASKED = { axis: 'y', set: {}, support: 'carriages', map: '' } as const;

describe('the body of a request', () => {
  it('asks for both designs on the same supports', () => {
    expect(bodyOf(ASKED)).toEqual({
      axis: 'y',
      previous: { support: 'carriages' },
      new: { support: 'carriages' },
    });
  });

  it('gives what belongs to both to both', () => {
    const set = { 'both.E': 210e9, 'new.thickness': 0.02 };
    expect(bodyOf({ ...ASKED, set, support: 'guides' })).toEqual({
      axis: 'y',
      previous: { E: 210e9, support: 'guides' },
      new: { E: 210e9, thickness: 0.02, support: 'guides' },
    });
  });

  it('puts one force on four movers, or a map', () => {
    const set = { 'load.force': 300, 'load.spacing_x': 0.1 };
    const body = bodyOf({ ...ASKED, set, map: 'new-design' });
    expect(body['load']).toEqual({ forces: [300, 300, 300, 300], spacing_x: 0.1 });
    expect(body['map']).toEqual({ name: 'new-design' });
  });
});

describe('what the server took', () => {
  const shape = { thickness: 0.016, length: 0.46, E: 70e9 };
  const found = {
    load: { forces: [400, 400, 400, 400], spacing_x: 0.24 },
    designs: { previous: { shape: { ...shape, thickness: 0.01 } }, new: { shape } },
  } as unknown as PlatformDocument;

  it('is found by the path of a field', () => {
    expect(valueIn(found, 'load.force')).toBe(400);
    expect(valueIn(found, 'load.spacing_x')).toBe(0.24);
    expect(valueIn(found, 'previous.thickness')).toBe(0.01);
    expect(valueIn(found, 'new.thickness')).toBe(0.016);
    expect(valueIn(found, 'both.length')).toBe(0.46);
    expect(valueIn(null, 'both.length')).toBeNull();
  });

  it('knows no path twice', () => {
    const fields = platformFields();
    expect(new Set(fields.map(({ path }) => path)).size).toBe(fields.length);
  });

  it('is shown as the server shows the field of the request', () => {
    expect(platformField('both.length')).toMatchObject({ label: 'length along x', factor: 1e3 });
    expect(platformField('load.force')).toMatchObject({ label: 'each normal force', unit: 'N' });
  });
});

it('both pictures have the same colours, from zero', () => {
  const range = shared([[[1e-6, 108e-6]], [[-2e-6, 34e-6]]]);
  expect(range).toEqual({ from: -2e-6, to: 108e-6 });
  expect(shared([[[1e-6, 2e-6]]]).from).toBe(0);
});
