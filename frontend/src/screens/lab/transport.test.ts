import { expect, it } from 'vitest';
import { transport } from './transport';

it('says which gains a play will run', () => {
  expect(transport('paused', 0)).toMatchObject({ play: 'Play', other: '' });
  expect(transport('paused', 1)).toMatchObject({
    play: 'Play with 1 change',
    other: 'Play as it was',
  });
  expect(transport('finished', 4)).toMatchObject({
    play: 'Play with 4 changes',
    other: 'Play as it was',
  });
  expect(transport('playing', 4)).toMatchObject({ play: 'Pause', other: '' });
});

it('does not play unasked what was taken back', () => {
  expect(transport('paused', 2, true)).toMatchObject({
    play: 'Play',
    other: 'Play with 2 changes',
  });
  expect(transport('paused', 0, true)).toMatchObject({ play: 'Play', other: '' });
});

it('gives a reason for what cannot be pressed', () => {
  expect(transport('finished', 0)).toMatchObject({
    noPlay: '',
    noStep: expect.stringMatching(/^Finished/),
  });
  expect(transport('playing', 0)).toMatchObject({
    noPlay: '',
    noStep: expect.stringMatching(/^Playing/),
  });
  expect(transport('stopped', 0)).toMatchObject({
    noPlay: expect.stringMatching(/^Stopped/),
    noStep: expect.stringMatching(/^Stopped/),
  });
  expect(transport(undefined, 0)).toMatchObject({
    noPlay: expect.stringMatching(/^There is no/),
    noStep: expect.stringMatching(/^There is no/),
  });
});
