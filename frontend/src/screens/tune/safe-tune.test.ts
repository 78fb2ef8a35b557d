import { expect, it } from 'vitest';
import type { SafeTune } from '../../app/api/types';
import { machineLines } from './candidates';
import { isOf, proposalText, rehearsedRows, runRows } from './safe-tune';

const K_P = 'variants.B.controller.x.k_p';
const FIRST = { id: 'r-first', name: 'first' };
const SECOND = { id: 'r-second', name: 'second' };

function motion(run: string | null, k_p: number, metric: number): SafeTune['motions'][number] {
  return { run, k_p, k_d: 900, metric, error: 2 * metric, force: 20, within: true };
}

const NEXT: NonNullable<SafeTune['proposal']> = {
  k_p: 4e5,
  k_d: 900,
  changes: { [K_P]: 4e5 },
  expected: 1e-6,
  error_high: 3e-6,
  force_high: 22,
  margins: { gain_margin: 3, phase_margin: 0.6 },
  plausible: { gain_margin: 2, phase_margin: 0.5 },
  improvement: 0.1,
  beyond: true,
  text: 'beyond every motion made: k_p 14 %',
};

const DOCUMENT: SafeTune = {
  error: 1e-5,
  force: 30,
  motions: [motion(FIRST.id, 3e5, 3e-6), motion(SECOND.id, 3.5e5, 2e-6)],
  proposal: NEXT,
  ended: '',
  best: 1,
  changes: { [K_P]: 3.5e5 },
  examined: { k_p: [], k_d: [], refused: [], expected: [] },
  warnings: [],
};

it('shows what was measured of the runs that are listed, whatever their order', () => {
  const third = { id: 'r-third', name: 'third' };
  const rows = runRows([SECOND, FIRST, third], DOCUMENT);
  expect(rows.map(({ motion: made }) => made?.metric)).toEqual([2e-6, 3e-6, undefined]);
  expect(rows.map(({ best }) => best)).toEqual([true, false, false]);
  expect(runRows([FIRST], null)).toEqual([{ run: FIRST, motion: null, best: false }]);
});

it('knows whether a proposal is of the runs that are listed', () => {
  expect(isOf([FIRST, SECOND], DOCUMENT)).toBe(true);
  expect(isOf([SECOND, FIRST], DOCUMENT)).toBe(false);
  expect(isOf([FIRST], DOCUMENT)).toBe(false);
});

it('lists the motions of a rehearsal, which are no runs', () => {
  const motions = DOCUMENT.motions.map((made) => ({ ...made, run: null }));
  const rows = rehearsedRows({ ...DOCUMENT, motions });
  expect(rows.map(({ run, best }) => [run, best])).toEqual([
    [null, false],
    [null, true],
  ]);
});

it('leaves gains beyond every motion made to a person', () => {
  expect(proposalText(NEXT)).toBe(
    'Beyond every motion made: k_p 14 %. It moves only if you start it.',
  );
  const within = { ...NEXT, beyond: false, text: 'no gain is larger than in the motions made' };
  expect(proposalText(within)).toBe('No gain is larger than in the motions made.');
});

it('makes candidates of the next gains and of the best ones on the machine', () => {
  const [next, best] = machineLines(DOCUMENT, 'rms');
  expect([next?.id, next?.set, next?.rms]).toEqual(['next', { [K_P]: 4e5 }, null]);
  expect([best?.id, best?.set, best?.peak]).toEqual([
    'best on the machine',
    { [K_P]: 3.5e5 },
    null,
  ]);
  expect(best?.rms).toEqual({ value: 2e-6, motor: 'the machine', velocity: null });
});

it('makes no candidate of the present gains', () => {
  const first = { ...DOCUMENT, motions: [], best: null, changes: {} };
  expect(machineLines({ ...first, proposal: { ...NEXT, changes: {} } }, 'peak')).toEqual([]);
});

it('does not call the best of a rehearsal that of the machine', () => {
  const motions = DOCUMENT.motions.map((made) => ({ ...made, run: null }));
  const lines = machineLines({ ...DOCUMENT, motions, proposal: null }, 'peak');
  expect(lines.map(({ id }) => id)).toEqual(['best rehearsed']);
});
