import { expect, it, vi } from 'vitest';
import { app } from '../../app/store.svelte';
import { sweep } from './sweep.svelte';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/')));

const scenario = { variants: { B: { controller: { x: { k_p: 2e5 } } } } };
app.session.info = { scenario } as never;

it('asks for cases and a seed only where they are drawn', async () => {
  const start = vi.spyOn(sweep.job, 'start').mockResolvedValue();
  const sent = async (combine: string) => {
    sweep.change({ combine, samples: 8, sampling_seed: 5, searcher: 'tpe' });
    await sweep.run();
    const body = start.mock.lastCall?.[1] as Record<string, unknown>;
    return ['samples', 'sampling_seed', 'searcher'].filter((name) => name in body);
  };
  expect(await sent('grid')).toEqual([]);
  expect(await sent('list')).toEqual([]);
  expect(await sent('sobol')).toEqual(['samples', 'sampling_seed']);
  expect(await sent('search')).toEqual(['samples', 'sampling_seed', 'searcher']);
});
