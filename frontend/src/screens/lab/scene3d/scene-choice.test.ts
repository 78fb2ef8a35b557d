import { expect, test } from 'vitest';
import { read, USUAL, written, type SceneChoice } from './scene-choice';

test('a choice is read as it was written', () => {
  const choice: SceneChoice = {
    camera: 'section',
    machine: 'B',
    axis: 'y',
    ghost: true,
    magnified: false,
    arrows: ['phases', 'friction'],
    filled: true,
    numbers: false,
  };
  expect(read(written(choice))).toEqual(choice);
  expect(read(written(USUAL))).toEqual(USUAL);
});

test('what is unknown is as usual', () => {
  expect(read('')).toEqual(USUAL);
  expect(read('<b>.sideways.ZZ.-nothing')).toEqual(USUAL);
});
