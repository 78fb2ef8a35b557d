import { describe, expect, it } from 'vitest';
import { withPath, type GivenPath } from './kept-sessions';
import { pathName } from './path-name';

const circle = { kind: 'circle', radius: 0.015 };
const star = { kind: 'path', points: [[0, 0]], laps: 1 };
const given = (name: string, table = star): GivenPath => ({ name, table });

describe('the name of the path', () => {
  it('is none where the scenario has its own', () => {
    expect(pathName(circle, circle, [given('my-star')])).toBe('');
    expect(pathName({ ...circle, radius: 0.02 }, circle, [])).toBe('');
  });

  it('is the saved name, whatever defaults the server added', () => {
    expect(pathName({ ...star, dwell: 0 }, circle, [given('my-star')])).toBe('my-star');
    expect(pathName({ ...star, laps: 3 }, circle, [given('my-star')])).toBe('my-star, edited');
  });

  it('is "drawn path" without a name, or where it came from elsewhere', () => {
    expect(pathName(star, circle, [given('')])).toBe('drawn path');
    expect(pathName(star, circle, [])).toBe('drawn path');
  });

  it('is that of the one that runs, after another was tried', () => {
    const other = { ...star, points: [[1, 1]] };
    const paths = withPath([given('my-star')], given('other', other));
    expect(pathName(star, circle, paths)).toBe('my-star');
    expect(pathName(other, circle, paths)).toBe('other');
  });
});
