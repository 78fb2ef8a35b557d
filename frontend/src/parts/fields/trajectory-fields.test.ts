import { expect, it } from 'vitest';
import { lines } from './trajectory-fields';

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
