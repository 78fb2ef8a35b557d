import { describe, expect, it } from 'vitest';
import { differencesOf, noteRecorded } from './source';
import { channelName, columnsOf, LAYOUTS, retargeted, scopeOf, unitsOf } from './scope-catalog';
import { scopeWith } from './scope-layout';

const UNITS = new Map([
  ['A.x.following_error', 'm'],
  ['B.x.thrust', 'N'],
  ['B.x.velocity', 'm/s'],
]);
const SUBJECT = { variant: 'B', axis: 'x' } as const;

describe('scopes', () => {
  const specs = LAYOUTS.flatMap(({ scopes }) => scopes(['A', 'B'], SUBJECT));
  const all = specs.map((spec, place) => scopeOf(spec, UNITS, place));

  it('tell B from A without colour', () => {
    const [a, b, difference] = all[0]?.all ?? [];
    expect(difference?.dash).toBeDefined();
    expect([a?.marker, b?.marker]).toEqual([undefined, 'dot']);
  });
  it('tell their traces apart by colour and line together', () => {
    for (const { title, traces } of all) {
      const looks = traces.map(({ ink, dash, marker, width }) => [ink, dash, marker, width].join());
      expect([title, new Set(looks).size]).toEqual([title, looks.length]);
    }
  });
  it('are called by what they share, and traces by what differs', () => {
    const named = (...channels: string[]) => {
      const { title, all: traces } = scopeOf(scopeWith(...channels), UNITS);
      return [title, traces.map(({ label }) => label)];
    };
    expect(named('A.x.following_error', 'B.x.following_error', 'A-B.x.following_error')).toEqual([
      'Following error x',
      ['A', 'B', 'A−B'],
    ]);
    expect(named('x.velocity_reference', 'A.x.velocity', 'B.x.velocity')).toEqual([
      'Velocity x',
      ['reference', 'A', 'B'],
    ]);
    expect(named('B.x.current_a', 'B.x.current_b')).toEqual(['Phase currents B x', ['a', 'b']]);
    expect(named('B.x.thrust', 'B.x.friction')).toEqual([
      'Thrust, friction B x',
      ['thrust', 'friction'],
    ]);
    expect(named('A.x.thrust', 'A.y.thrust')).toEqual(['Thrust', ['A x', 'A y']]);
  });
  it('take the unit of each channel, of a difference that of its parts', () => {
    const { all: traces } = scopeOf(scopeWith('A-B.x.following_error', 'B.x.thrust'), UNITS);
    expect(traces.map(({ unit }) => unit)).toEqual(['m', 'N']);
  });
  it('need each column once, and nothing that is computed here', () => {
    const columns = columnsOf(all, ['A', 'B']);
    expect(new Set(columns).size).toBe(columns.length);
    expect(columns).toContain('B.x.current_a');
    expect(columns.some((column) => column.startsWith('A-B'))).toBe(false);
  });
  it('work with one variant', () => {
    const [first] = LAYOUTS[0]?.scopes(['A'], { variant: 'A', axis: 'x' }) ?? [];
    expect(first?.channels).toEqual(['A.x.following_error']);
  });
});

it('differences are of what both variants have', () => {
  const columns = ['A.x.thrust', 'B.x.thrust', 'A.y.thrust', 'x.position_reference'];
  expect(differencesOf(columns)).toEqual([
    { name: 'A-B.x.thrust', minuend: 'A.x.thrust', subtrahend: 'B.x.thrust' },
  ]);
});

it('another subject changes the scopes of that one alone', () => {
  const to = { variant: 'A', axis: 'y' } as const;
  const after = (...channels: string[]) =>
    retargeted({ ...scopeWith(...channels), hidden: channels.slice(0, 1) }, SUBJECT, to);
  expect(after('B.x.thrust', 'B.x.friction')).toMatchObject({
    channels: ['A.y.thrust', 'A.y.friction'],
    hidden: ['A.y.thrust'],
  });
  expect(after('x.velocity_reference', 'A.x.velocity', 'B.x.velocity').channels).toEqual([
    'y.velocity_reference',
    'A.y.velocity',
    'B.y.velocity',
  ]);
  const errors = ['A.x.following_error', 'B.x.following_error'];
  expect(after(...errors).channels).toEqual(errors);
});

it('a channel has a name in words', () => {
  expect(channelName('A.x.following_error')).toBe('Following error x of A');
  expect(channelName('y.position_reference')).toBe('Position reference y');
  expect(channelName('B.x.current_command_a')).toBe('Current a command x of B');
});

it('a measured column with an equals sign is no math channel', () => {
  const names = ['E[V]=1 (a)', 'E[V]=2 (a)'];
  noteRecorded(names);
  const units = unitsOf(names.map((name) => ({ name, unit: 'V' })));
  const titles = names.map((name) => scopeOf(scopeWith(name), units).title);
  expect(titles).toEqual(names);
  expect(scopeOf(scopeWith(...names), units).all.map(({ label }) => label)).toEqual(names);
  expect(scopeOf(scopeWith('sum=A.x.thrust'), units).title).toBe('sum');
});
