import { expect, test, vi } from 'vitest';
import { matching, ofKeys, type Command } from './commands';

const command = (name: string, place: string): Command => ({ name, place, key: '', run: () => {} });

const ALL = [
  command('A.x.thrust', 'channel'),
  command('Thrust of the map', 'Motor'),
  command('k p x', 'Controllers'),
];

test('every word has to occur, in name or place', () => {
  expect(matching(ALL, 'contr x')).toEqual([ALL[2]]);
  expect(matching(ALL, 'thrust channel')).toEqual([ALL[0]]);
  expect(matching(ALL, 'nothing')).toEqual([]);
});

test('words of the hint count too', () => {
  const keep = { ...command('Keep', 'Trigger'), about: 'Keep this capture as a run' };
  expect(matching([...ALL, keep], 'capture run')).toEqual([keep]);
});

test('what begins with the first word comes first', () => {
  expect(matching(ALL, 'thrust').map(({ name }) => name)).toEqual([
    'Thrust of the map',
    'A.x.thrust',
  ]);
  expect(matching(ALL, '')).toEqual(ALL);
});

test('keys that do one thing are commands', () => {
  const play = vi.fn();
  const table = {
    title: 'Lab',
    keys: [
      { keys: 'Space', does: 'Play or pause' },
      { keys: 's, S', does: 'Step' },
    ],
  };
  const commands = ofKeys(table, { ' ': play, s: () => {} });
  expect(commands.map(({ name, key }) => [name, key])).toEqual([['Play or pause', 'Space']]);
  commands[0]?.run();
  expect(play).toHaveBeenCalledOnce();
});

test('a view stands above what only has the word in its hint', () => {
  const hint = { ...command('Window function: Hann', 'Views'), about: 'of the fft' };
  const view = { ...command('Spectrum: spectral density', 'view'), about: 'fft psd' };
  expect(matching([hint, view], 'fft')).toEqual([view, hint]);
});
