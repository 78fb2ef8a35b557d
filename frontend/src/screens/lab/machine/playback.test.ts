import { describe, expect, it } from 'vitest';
import { Playback } from './playback';

const range = { from: 4, to: 10 };
const still = () => 0;

describe('the moment that is shown', () => {
  it('is the one that is pointed at, and goes on from there', () => {
    const playback = new Playback();
    expect(playback.at(0, { pointed: 5, range, moves: true }, still)).toBe(5);
    const next = playback.at(100, { pointed: undefined, range, moves: true }, still);
    expect(next).toBeCloseTo(5.03);
  });

  it('waits from one picture to the next, and begins again at the end', () => {
    const playback = new Playback();
    playback.at(0, { pointed: 9.99, range, moves: true }, still);
    expect(playback.at(100, { pointed: undefined, range, moves: true }, still)).toBeCloseTo(10.02);
    expect(playback.at(110, { pointed: undefined, range, moves: true }, still)).toBeNull();
    expect(playback.at(200, { pointed: undefined, range, moves: true }, still)).toBeCloseTo(4.03);
  });

  it('is slower where the stator would pass too fast to be followed', () => {
    const playback = new Playback();
    playback.at(0, { pointed: 5, range, moves: true }, still);
    const next = playback.at(100, { pointed: undefined, range, moves: true }, (time) => 100 * time);
    expect(next).toBeCloseTo(5.002);
  });

  it('rests at the largest error where nothing is to move', () => {
    const playback = new Playback();
    playback.worst = 7;
    expect(playback.at(0, { pointed: undefined, range, moves: false }, still)).toBe(7);
  });
});
