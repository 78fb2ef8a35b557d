import { describe, expect, it, vi } from 'vitest';
import type { PlatformDocument } from '../../../app/api/types';
import { bodyOf, GROUPS, inRequest, shared, valueIn } from './platform-fields';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

describe('the body of a request', () => {
  it('asks for both designs on the same supports', () => {
    expect(bodyOf({ 'map.name': '' }, 'y', 'carriages')).toEqual({
      axis: 'y',
      previous: { support: 'carriages' },
      new: { support: 'carriages' },
    });
  });

  it('gives what belongs to both to both', () => {
    const set = { 'both.E': 210e9, 'new.thickness': 0.02 };
    expect(bodyOf(set, 'y', 'guides')).toEqual({
      axis: 'y',
      previous: { E: 210e9, support: 'guides' },
      new: { E: 210e9, thickness: 0.02, support: 'guides' },
    });
  });

  it('puts one force on four movers, or a map', () => {
    const set = { 'load.force': 300, 'load.spacing_x': 0.1, 'map.name': 'new-design' };
    const body = bodyOf(set, 'y', 'carriages');
    expect(body['load']).toEqual({ forces: [300, 300, 300, 300], spacing_x: 0.1 });
    expect(body['map']).toEqual({ name: 'new-design' });
  });
});

describe('what the server took', () => {
  const shape = { thickness: 0.016, length: 0.46, E: 70e9 };
  const bent = {
    load: { forces: [400, 400, 400, 400], spacing_x: 0.24 },
    designs: { previous: { shape: { ...shape, thickness: 0.01 } }, new: { shape } },
  } as unknown as PlatformDocument;

  it('is found by the path of a field', () => {
    expect(valueIn(bent, 'load.force')).toBe(400);
    expect(valueIn(bent, 'load.spacing_x')).toBe(0.24);
    expect(valueIn(bent, 'previous.thickness')).toBe(0.01);
    expect(valueIn(bent, 'new.thickness')).toBe(0.016);
    expect(valueIn(bent, 'both.length')).toBe(0.46);
    expect(valueIn(null, 'both.length')).toBeNull();
  });

  it('knows no path twice', () => {
    const paths = GROUPS.flatMap((group) => group.paths);
    expect(new Set(paths).size).toBe(paths.length);
  });

  it('has the field of the request for each of the form', () => {
    expect(inRequest('both.length')).toBe('new.length');
    expect(inRequest('load.force')).toBe('load.forces');
    expect(inRequest('previous.thickness')).toBe('previous.thickness');
  });
});

it('both pictures have the same colours, from zero', () => {
  const range = shared([[[1e-6, 108e-6]], [[-2e-6, 34e-6]]]);
  expect(range).toEqual({ from: -2e-6, to: 108e-6 });
  expect(shared([[[1e-6, 2e-6]]]).from).toBe(0);
});
