import { beforeEach, expect, it, vi } from 'vitest';
import { served } from '../../app/fields/fields.svelte';
import { ResponseForm, STEPPED } from './response-form.svelte';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

const field = (label: string, more: object) => ({ label, unit: '', factor: 1, ...more });

let form: ResponseForm;
beforeEach(() => {
  served.requests = {
    response: {
      axis: field('axis', { default: 'x' }),
      signal: field('signal', { default: 'multisine' }),
      force: field('force', { unit: 'N', example: 1 }),
      seconds: field('time', { unit: 's', default: 60 }),
    },
  } as never;
  form = new ResponseForm();
});

it('asks for nothing but what was entered', () => {
  expect(form.body()).toEqual({});
  form.change({ signal: 'chirp' });
  form.change({ force: 2 });
  expect(form.body()).toEqual({ signal: 'chirp', force: 2 });
  expect(form.number('seconds')).toBe(60);
});

it('takes the time that stepped sines need, unless another is entered', () => {
  form.change({ signal: 'stepped-sine' });
  expect(form.number('seconds')).toBe(STEPPED);
  expect(form.body()).toEqual({ signal: 'stepped-sine', seconds: STEPPED });
  form.change({ seconds: 900 });
  expect(form.body()).toEqual({ signal: 'stepped-sine', seconds: 900 });
  form.reset(['seconds']);
  form.change({ signal: 'noise' });
  expect(form.number('seconds')).toBe(60);
});

it('an earlier request comes back with its usual time, and says in what the form differs', () => {
  const request = { axis: 'y', signal: 'stepped-sine', force: null, seconds: STEPPED };
  expect(form.others(request)).toEqual(['signal', 'time']);
  form.restore(request);
  expect(form.entered).toEqual({ signal: 'stepped-sine' });
  expect(form.others(request)).toEqual([]);
  form.change({ force: 3 });
  expect(form.others(request)).toEqual(['force']);
  form.restore({ axis: 'x' });
  expect(form.body()).toEqual({});
});
