import { expect, it } from 'vitest';
import { KINDS, ofKind, ofSource, readChoice, writeChoice, type ViewChoice } from './view-choice';

const CHOICE: ViewChoice = {
  kind: 'xy',
  of: 'r-7f3',
  channels: ['B.x.velocity', 'B.x.friction'],
  stretch: { from: 4.5, to: 10.25 },
};

it('is the same after it was written into an address and read', () => {
  expect(writeChoice(CHOICE)).toBe('xy r-7f3 4.5..10.25 B.x.velocity B.x.friction');
  const math = ['power = A.x.thrust * A.x.velocity', '50% e=2*B.x.thrust'];
  const others: ViewChoice[] = [
    CHOICE,
    { ...CHOICE, stretch: null, channels: [] },
    { ...CHOICE, kind: 'spectrum', of: 'staged', channels: math },
    { ...CHOICE, stretch: { from: 0, to: 1e-7 } },
  ];
  for (const choice of others) {
    const address = new URLSearchParams({ pane: writeChoice(choice) }).toString();
    expect(readChoice(new URLSearchParams(address).get('pane'))).toEqual(choice);
  }
});

it('reads nothing from what is no choice, and the rest of what is damaged', () => {
  for (const text of [null, '', 'xy', 'bode lab', 'toString lab', 'xy ../etc', 'xy a/b'])
    expect(readChoice(text)).toBeNull();
  expect(readChoice('xy lab 5..2 a%zz b')).toEqual({
    kind: 'xy',
    of: 'lab',
    channels: ['a%zz', 'b'],
    stretch: null,
  });
  const many = Array.from({ length: 99 }, (_, i) => `c${i}`);
  expect(readChoice(`spectrum lab ${many.join(' ')}`)?.channels).toHaveLength(8);
});

it('keeps its channels for another source, and drops those of another kind', () => {
  expect(ofSource(CHOICE, 'live')).toEqual({ ...CHOICE, of: 'live', stretch: null });
  expect(ofKind(CHOICE, 'spectrum')).toEqual({ ...CHOICE, kind: 'spectrum', channels: [] });
  expect(ofKind(CHOICE, 'xy')).toBe(CHOICE);
});

it('names each kind differently', () => {
  const names = Object.values(KINDS).map(({ name }) => name);
  expect(new Set(names).size).toBe(names.length);
});
