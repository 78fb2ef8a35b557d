import { expect, it } from 'vitest';
import type { Why } from '../../../app/api/types';
import { mendText, mendTitle, NOW, questionText, whyRows } from './why-text';

const WHY = {
  variant: 'B',
  axis: 'y',
  time: 10.33,
  peak: 10e-6,
  goal: 5e-6,
  causes: [
    { id: 'stribeck', label: 'Stribeck effect', meaning: '', error: 3e-6, share: 0.7, set: {} },
    { id: 'delay', label: 'delay', meaning: '', error: null, share: null, set: {} },
    { id: 'compensation', label: 'alone', meaning: '', error: 40e-6, share: -3, set: {} },
  ],
  mend: null,
  why_not: 'None of the 10 changes tried reaches the goal.',
} as unknown as Why;

it('draws each cause against the peak as it is', () => {
  const [stribeck, delay, alone] = whyRows(WHY);
  expect(stribeck).toMatchObject({ error: '3.00', share: '70.0 %', helps: false });
  expect((stribeck?.length ?? 0) / NOW).toBeCloseTo(0.3);
  expect(delay).toMatchObject({ error: 'diverges', share: '–' });
  expect(alone).toMatchObject({ length: 1, share: '−300 %', helps: true });
});

it('asks and answers in words', () => {
  expect(questionText(WHY)).toBe('Why does B err by 10.0 µm on y at 10.33 s?');
  expect(mendText(WHY)).toEqual({ head: 'Nothing found that reaches 5.00 µm.', rest: WHY.why_not });
  const live = { ...WHY, time: 4.522, period: 3 };
  expect(questionText(live, 141)).toBe('Why does B err by 10.0 µm on y at 139.522 s?');
  expect(questionText({ ...live, period: null }, 141)).toMatch(/ at 4\.522 s\?$/);
  const mend = {
    reaches: true,
    label: 'k_p y',
    factor: 1.5,
    window_error: 4e-6,
    gain_margin: 2,
    phase_margin: Math.PI / 4,
  };
  expect(mendText({ ...WHY, mend } as unknown as Why)).toEqual({
    head: 'k_p y × 1.50',
    rest: '4.00 µm over the window, GM 6.02 dB, PM 45.0°',
  });
  const small = { ...WHY, mend: { ...mend, window_error: 0.755e-6 } } as unknown as Why;
  expect(mendText(small).rest).toMatch(/^0\.755 µm over the window/); // as in the table
  const eased = { ...WHY, mend: { ...mend, eased: true } } as unknown as Why;
  expect(mendText(eased).rest).toMatch(/, beyond a limit, as now$/);
  expect(mendTitle(eased)).toBe('The smallest change that makes no margin worse');
  const near = { ...WHY, mend: { ...mend, reaches: false } } as unknown as Why;
  expect(mendTitle(near)).toBe('Nothing tried reaches 5.00 µm; what comes nearest');
});
