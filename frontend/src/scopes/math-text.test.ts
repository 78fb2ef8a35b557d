import { expect, it } from 'vitest';
import fixture from '../../../tests/fixtures/expressions.json';
import { MATH_MAX, mathColumn, mathLabel, mathParts, refusedBeside } from '../plot/math-column';
import { layoutText, readLayout, scopeWith } from '../plot/scope-layout';
import { completed, completions, FUNCTIONS, wordAt } from './math-text';

const CHANNELS = [
  { name: 'B.x.following_error', unit: 'm' },
  { name: 'Temp (degC)', unit: 'degC' },
];

it('knows the functions that the server has', () => {
  expect(Object.keys(FUNCTIONS).sort()).toEqual([...fixture.functions].sort());
});

it('completes the word at the caret', () => {
  const text = 'hypot(B.x.foll + 1';
  expect(wordAt(text, 14)).toEqual({ start: 6, word: 'B.x.foll' });
  const [channel] = completions('B.x.foll', CHANNELS);
  expect(completed(text, 14, channel?.text ?? '')).toEqual({
    text: 'hypot(B.x.following_error + 1',
    caret: 25,
  });
  expect(completions('hy', CHANNELS).map((each) => each.text)).toEqual(['hypot(']);
  expect(completions('temp', CHANNELS)[0]?.text).toBe('"Temp (degC)"');
  expect(completions('B.x.following_error', CHANNELS)).toEqual([]);
});

it('is called by its name, and keeps its expression in a layout', () => {
  const column = mathColumn({ name: ' e ', expression: ' min(u, "a;b") * 50 [nm] ' });
  expect(column).toBe('e=min(u, "a;b") * 50 [nm]');
  expect(mathParts(column)).toEqual({ name: 'e', expression: 'min(u, "a;b") * 50 [nm]' });
  expect([mathLabel(column), mathLabel('=u'), mathLabel(`=${'u+'.repeat(40)}v`).length]).toEqual([
    'e',
    'u',
    32,
  ]);
  const scope = { ...scopeWith('A.x.thrust', column), hidden: [column], own: ['A.x.thrust'] };
  const text = layoutText([scope, scopeWith(`${'n'.repeat(40)}=${'('.repeat(200)}`)]);
  expect(readLayout(text)?.[0]).toEqual(scope);
  expect(readLayout(text)?.[1]?.channels[0]).toHaveLength(241);
});

it('is refused beside another of its name, and beyond the most at once', () => {
  const same = refusedBeside(['e=u', 'e=v', '=u', 'u=v', 'f=u']);
  expect([...same.keys()]).toEqual(['e=v', 'u=v']);
  expect(same.get('e=v')).toContain('e; choose another name');
  const many = Array.from({ length: MATH_MAX + 1 }, (_, i) => `n${i}=u`);
  expect([...refusedBeside(many).keys()]).toEqual([`n${MATH_MAX}=u`]);
});
