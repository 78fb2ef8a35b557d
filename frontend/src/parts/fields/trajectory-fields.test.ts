import { describe, expect, it } from 'vitest';
import { lines, meaning, repeated, repeats, type Repeats } from './trajectory-fields';

it('makes a line of every number, main ones first', () => {
  const fields = lines({
    kind: 'circle',
    center: { x: 0, y: 0 },
    radius: 0.015,
    direction: 'ccw',
    lead_in: null,
  });
  expect(fields.map(({ path, kind, main }) => [path, kind, main])).toEqual([
    ['trajectory.radius', 'number', true],
    ['trajectory.center.x', 'number', false],
    ['trajectory.center.y', 'number', false],
    ['trajectory.direction', 'choice', false],
    ['trajectory.lead_in', 'number', false],
  ]);
});

it('tells how long a list is', () => {
  expect(
    lines({
      kind: 'polygon',
      vertices: [
        [0, 0],
        [1, 0],
        [0, 1],
      ],
    }),
  ).toEqual([{ kind: 'list', path: 'trajectory.vertices', main: true, length: 3 }]);
});

const circle = { kind: 'circle', radius: 0.015, laps: 3, for_ever: true };

describe('repeats', () => {
  it('tells once from n times and for ever', () => {
    expect(repeats(circle)?.mode).toBe('ever');
    expect(repeats({ ...circle, for_ever: false })?.mode).toBe('times');
    expect(repeats({ ...circle, for_ever: false, laps: 1 })?.mode).toBe('once');
    expect(repeats({ kind: 'sine', cycles: 4, for_ever: false })).toMatchObject({
      mode: 'times',
      count: 'cycles',
    });
  });

  it('has no choice for what ends elsewhere, and none for what has no laps', () => {
    const open = { kind: 'path', points: [], closed: false, laps: 1 };
    expect(repeats(open)).toMatchObject({ mode: 'once', only: 'It ends elsewhere than it begins' });
    expect(repeats({ kind: 'trapezoid', there_and_back: false, cycles: 1 })?.mode).toBe('once');
    const way = { kind: 'waypoints', laps: 1 };
    expect(
      repeats({
        ...way,
        points: [
          [0, 0],
          [1, 0],
        ],
      })?.mode,
    ).toBe('once');
    expect(
      repeats({
        ...way,
        points: [
          [0, 0],
          [1, 0],
          [0, 0],
        ],
      })?.mode,
    ).toBe('ever');
    expect(repeats({ kind: 'point', duration: 1 })).toBeNull();
  });

  it('changes what the choice needs and nothing else', () => {
    const now = repeats(circle) as Repeats;
    expect(repeated(now, 'once')).toEqual({ for_ever: false, laps: 1 });
    expect(repeated(now, 'times')).toEqual({ for_ever: false, laps: 3 });
    expect(repeated({ ...now, laps: 1 }, 'times')).toEqual({ for_ever: false, laps: 2 });
    expect(repeated(now, 'ever')).toEqual({ for_ever: true });
    expect(meaning(now)).toContain('end after 3 laps');
  });
});
