import { expect, test } from 'vitest';
import { sectionRows, shareText, whyText } from './scene-numbers';

const movers = {
  thrust: 4,
  current: [0, 2.5, 1],
  phase_thrust: [0, 5, -1],
  phase_normal_force: [0, 20, 8],
  to_aligned: [0.1e-3, 1.75e-3, -0.6e-3],
};

test('the phase that pulls most is named with its distance', () => {
  expect(whyText(movers, 'B', 'x')).toContain(
    'Phase b pulls most, to the right: its teeth stand 1.75 mm',
  );
  const backwards = { ...movers, phase_thrust: [0, -5, -1], to_aligned: [0, -1.75e-3, -0.6e-3] };
  expect(whyText(backwards, 'B', 'x')).toContain('to the left');
  expect(whyText({ ...movers, current: [0, 0, 0.01] }, 'B', 'x')).toBe('No phase of B x pulls.');
});

test('shares are of the thrust of the axis', () => {
  expect(sectionRows(movers).map(({ thrust }) => shareText(thrust, movers.thrust))).toEqual([
    '0 %',
    '125 %',
    '−25 %',
  ]);
  expect(shareText(1, 0.01)).toBe('–');
});
