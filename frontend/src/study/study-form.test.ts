import { describe, expect, it, vi } from 'vitest';
import { ApiError } from '../app/api/client';
import type { ProblemField } from '../app/api/types';
import { StudyForm } from './study-form.svelte';

const { storage } = vi.hoisted(() => {
  const storage = new Map<string, string>();
  vi.stubGlobal('location', new URL('http://lab/'));
  vi.stubGlobal('localStorage', {
    getItem: (key: string) => storage.get(key) ?? null,
    setItem: (key: string, value: string) => storage.set(key, value),
  });
  return { storage };
});

/** A form in a browser that has kept this. */
function formOver(kept: object | null = null, initial = {}): StudyForm {
  storage.clear();
  if (kept) storage.set('motionlab.study.tune', JSON.stringify(kept));
  return new StudyForm('tune', initial);
}

function refused(form: StudyForm, ...errors: ProblemField[]): void {
  form.refuse(new ApiError({ title: '', status: 422, detail: '', errors }));
}

describe('a form of a study', () => {
  it('has the defaults of the server, and asks for what was entered alone', () => {
    const form = formOver(null, { plants: ['matched'] });
    expect([form.number('starts'), form.text('axis')]).toEqual([4, 'both']);
    form.change({ starts: 2, 'constraints.Ms': 1.8, 'constraints.force': null });
    expect(form.body()).toEqual({
      plants: ['matched'],
      starts: 2,
      constraints: { Ms: 1.8, force: null },
    });
    form.reset();
    expect(form.body()).toEqual({ plants: ['matched'] });
  });

  it('keeps what was entered, and leaves out what is damaged', () => {
    formOver().change({ starts: 2 });
    expect(new StudyForm('tune').number('starts')).toBe(2);
    const form = formOver({
      starts: 'many',
      'bounds.k_p': 5,
      plants: [null],
      unknown: 1,
      axis: 'x',
    });
    expect(form.entered).toEqual({ axis: 'x' });
    expect(formOver([5]).entered).toEqual({});
  });

  it('takes a request, whose defaults are not entered', () => {
    const form = formOver({ evaluations: 7 });
    const request = {
      scenario: 'circle',
      axis: 'x',
      starts: 4,
      window: { start: 1, end: 3 },
      constraints: { gain_margin: null },
    };
    form.restore(request);
    expect(form.entered).toEqual({
      axis: 'x',
      'window.start': 1,
      'window.end': 3,
      'constraints.gain_margin': null,
    });
    expect(form.differing(request, form.body())).toEqual([]);
  });

  it('names the settings in which a request differs, a table once', () => {
    const form = formOver();
    form.change({ starts: 2, 'constraints.Ms': 1.8, 'constraints.gain_margin': null });
    expect(form.differing({ starts: 4 }, form.body())).toEqual(['limits', 'starts']);
    expect(form.differing(undefined, form.body())).toEqual([]);
  });
});

describe('what is refused', () => {
  const gains = { loc: 'bounds.k_p', message: 'the lower end must lie below the upper one' };

  it('stands at its field where that is shown, else with its name', () => {
    const form = formOver();
    refused(form, gains);
    expect(form.unplaced).toEqual(['range of k_p: The lower end must lie below the upper one.']);
    form.place(['bounds.k_p'], 1);
    expect(form.unplaced).toEqual([]);
    expect(form.problems['bounds.k_p']).toBe('The lower end must lie below the upper one.');
  });

  it('of a table stands at its number that was changed last', () => {
    const form = formOver();
    form.change({ 'bounds.k_d': [1, 2] });
    refused(form, { loc: 'bounds', message: 'too wide' }, { loc: 'bounds', message: 'too wide' });
    expect(form.problems).toEqual({ 'bounds.k_d': 'Too wide.' });
    form.change({ starts: 2 });
    expect(form.problems).toEqual({});
  });

  it('without a field is said as a whole', () => {
    const form = formOver();
    form.refuse(new Error('no answer'));
    expect(form.unplaced).toEqual(['no answer']);
  });
});
