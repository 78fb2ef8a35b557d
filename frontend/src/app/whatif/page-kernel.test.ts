import { beforeEach, describe, expect, it, vi } from 'vitest';
import { Crew, type Port, WorkerEnded } from '../../kernel/crew';
import { exampleLanes } from '../../kernel/example-lanes';
import { type Lanes, packLanes } from '../../kernel/lanes';
import type { About } from '../../kernel/module';
import type { Answer, Request } from '../../kernel/tasks';
import type { Changes, Scenario } from '../api/types';
import { LaneChanges, type Numbers } from './lane-changes';
import { Obstacle, PageKernel } from './page-kernel';

const about = { module: 'abc' } as About;
vi.mock('../../kernel/module', async (original) => ({
  ...(await original<object>()),
  aboutOf: () => about,
}));

const scenario = { variants: { A: {}, B: {} } } as unknown as Scenario;
const question = (set: Changes, columns = ['x.position_reference', 'B.y.thrust']) => ({
  scenario,
  set,
  columns,
});
const curve = (value: number) => ({
  minimum: new Float32Array(4).fill(value),
  maximum: new Float32Array(4).fill(value),
});

/** A kernel whose workers note their requests, and a server that answers with some lanes. */
async function kernelOf(
  change: Partial<Lanes> = {},
  fails: (request: Request) => boolean = () => false,
) {
  const requests: string[] = [];
  const port = (place: number): Port => ({
    post(request): Promise<Answer> {
      const of = request.kind === 'run' ? ` ${request.run.variant}` : '';
      if (request.kind !== 'open') requests.push(`${place} ${request.kind}${of}`);
      if (fails(request)) return Promise.reject(new Error('out of memory'));
      if (request.kind === 'run') {
        const curves = request.run.columns.map(() => curve(place));
        const figures = { axes: { x: { itae: 1 } }, contour: {} };
        const loops = request.run.linear ? { axes: {}, note: request.run.variant } : null;
        return Promise.resolve({ diverged: null, windows: [figures], curves, loops });
      }
      if (request.kind !== 'curves') return Promise.resolve(null);
      return Promise.resolve(request.columns.map(() => curve(place)));
    },
    end: () => undefined,
  });
  const crew = await Crew.of({} as WebAssembly.Module, [port(0), port(1)]);
  const whatifLanes = vi.fn(({ inputs }: { inputs?: string }) => {
    const known = inputs === 'i' ? { inputs: null, tables: null, rows: [] } : {};
    return Promise.resolve(packLanes({ ...exampleLanes(), ...change, ...known }));
  });
  const changes = new LaneChanges();
  vi.spyOn(changes, 'take');
  vi.spyOn(changes, 'lanesOf').mockResolvedValue(null);
  const kernel = new PageKernel(changes, () => Promise.resolve(crew));
  const run = (set: Changes, columns?: string[]) =>
    kernel.run({ whatifLanes }, question(set, columns), null, 4, AbortSignal.timeout(1000));
  return { kernel, run, requests, whatifLanes, changes, port };
}

let made: Awaited<ReturnType<typeof kernelOf>>;
beforeEach(async () => {
  made = await kernelOf();
});

describe('a what-if in the page', () => {
  it('runs each variant in a worker, on inputs that are sent once', async () => {
    const { run, requests } = made;
    const { source, result, duration } = await run({ mass: 1 });
    expect(requests).toEqual(['0 inputs', '0 run A', '1 inputs', '1 run B']);
    expect([source.at('x.position_reference', 2), source.at('B.y.thrust', 2)]).toEqual([0, 1]);
    expect([source.start, source.step, source.last]).toEqual([1, 1, 4]);
    expect([result.window, duration]).toEqual([{ start: 1, end: 5 }, 5]);
  });

  it('has margins of both variants, unless a schedule changes their parameters', async () => {
    expect((await made.run({ mass: 1 })).loops).toBeNull();
    const { run } = await kernelOf({ epochs: [0], lanes: new Float64Array(8) });
    const loops = { A: { axes: {}, note: 'A' }, B: { axes: {}, note: 'B' } };
    expect((await run({ mass: 1 })).loops).toEqual(loops);
  });

  it('asks the server for what the page cannot make', async () => {
    const { run, requests, whatifLanes, changes } = made;
    await run({ mass: 1 });
    requests.length = 0;
    const { lanes, inputs } = vi.mocked(changes.take).mock.lastCall?.[1] as Numbers;
    const own = lanes.lanes.slice();
    own[7] = 50;
    vi.mocked(changes.lanesOf).mockResolvedValueOnce({ lanes: { ...lanes, lanes: own }, inputs });
    await run({ mass: 1, gain: 50 });
    expect(whatifLanes).toHaveBeenCalledTimes(1);
    expect(requests).toEqual(['1 run B']); // A is as it was
    await run({ mass: 2 });
    expect(whatifLanes).toHaveBeenCalledTimes(2);
    expect(requests).not.toContain('0 inputs');
  });

  it('reads further curves of its latest run only', async () => {
    const { kernel, whatifLanes } = made;
    const [first, second] = [question({ mass: 1 }), question({ mass: 2 })];
    const signal = AbortSignal.timeout(1000);
    for (const each of [first, second]) await kernel.run({ whatifLanes }, each, null, 4, signal);
    const range = { from: 0, to: 2 };
    expect(await kernel.curves(first, ['B.y.thrust'], range, 100)).toBeNull();
    const source = await kernel.curves(second, ['B.y.thrust'], range, 100);
    expect([source?.start, source?.step, source?.last]).toEqual([0, 0.5, 4]);
  });

  it('runs one of several at a time, so that each reads its own samples', async () => {
    const { kernel, requests, whatifLanes } = made;
    const [first, second] = [question({ mass: 1 }), question({ mass: 2 })];
    const signal = AbortSignal.timeout(1000);
    const begun = kernel.run({ whatifLanes }, first, null, 4, signal);
    const reading = kernel.curves(first, ['B.y.thrust'], { from: 0, to: 2 }, 100);
    await Promise.all([begun, kernel.run({ whatifLanes }, second, null, 4, signal)]);
    expect(await reading).not.toBeNull();
    expect(requests.slice(4, 6)).toEqual(['0 curves', '1 curves']);
    expect(whatifLanes.mock.calls.map(([{ inputs }]) => inputs)).toEqual(['', 'i']);
  });

  it('takes no tables of another force map', async () => {
    const { run, whatifLanes } = made;
    await run({ mass: 1 });
    const keys = { inputs: 'i', tables: 'other' };
    whatifLanes.mockResolvedValueOnce(packLanes({ ...exampleLanes(), keys, tables: null }));
    await expect(run({ mass: 2 })).rejects.toThrow('missing');
  });
});

describe('the server has to run', () => {
  it('math channels, and what it says only it can', async () => {
    await expect(made.run({}, ['p=B.x.thrust * 2'])).rejects.toBeInstanceOf(Obstacle);
    await expect(made.run({}, ['B.x.law_w'])).rejects.toBeInstanceOf(Obstacle);
    expect(made.whatifLanes).not.toHaveBeenCalled();
    const other = await kernelOf({ module: 'other' });
    await expect(other.run({})).rejects.toThrow('another version');
  });

  it('in a page of another version, which asks for no more numbers', async () => {
    const { run, whatifLanes } = await kernelOf({ module: 'other' });
    for (const set of [{ mass: 1 }, { mass: 2 }]) {
      await expect(run(set)).rejects.toEqual(
        new Obstacle('this page has the kernel of another version'),
      );
    }
    expect(whatifLanes).toHaveBeenCalledTimes(1);
  });

  it('what it said only it can, for some seconds without being asked', async () => {
    const { run, whatifLanes } = made;
    const now = vi.spyOn(performance, 'now').mockReturnValue(0);
    const head = new TextEncoder().encode(JSON.stringify({ obstacle: 'too long' }).padEnd(24));
    const buffer = new Uint8Array([head.length, ...Array<number>(7).fill(0), ...head]).buffer;
    whatifLanes.mockResolvedValue(buffer);
    for (const laps of [100, 101]) await expect(run({ laps })).rejects.toThrow('too long');
    expect(whatifLanes).toHaveBeenCalledTimes(1);
    await expect(run({ laps: 100, mass: 1 })).rejects.toThrow('too long');
    expect(whatifLanes).toHaveBeenCalledTimes(2);
    now.mockReturnValue(6000);
    await expect(run({ laps: 100, mass: 1 })).rejects.toThrow('too long');
    expect(whatifLanes).toHaveBeenCalledTimes(3);
    now.mockRestore();
  });

  it('what a worker fails on; the next one begins anew', async () => {
    let full = true;
    const { run, requests } = await kernelOf({}, ({ kind }) => full && kind === 'inputs');
    await expect(run({})).rejects.toBeInstanceOf(Obstacle);
    full = false;
    requests.length = 0;
    await run({});
    expect(requests).toEqual(['0 inputs', '0 run A', '1 inputs', '1 run B']);
  });

  it('what workers end on; others take their place once', async () => {
    let opened = 0;
    const end = vi.fn();
    const ends = () => Promise.reject(new WorkerEnded('ended'));
    const port: Port = {
      post: ({ kind }) => (kind === 'open' ? Promise.resolve(null) : ends()),
      end,
    };
    const kernel = new PageKernel(new LaneChanges(), () => {
      opened += 1;
      return Crew.of({} as WebAssembly.Module, [port]);
    });
    for (let asks = 0; asks < 3; asks++) {
      const run = kernel.run(made, question({}), null, 4, AbortSignal.timeout(1000));
      await expect(run).rejects.toEqual(new Obstacle('ended'));
    }
    expect(opened).toBe(2);
    expect(end).toHaveBeenCalled();
  });

  it('everything while the module takes long to load, until it is there', async () => {
    let loaded: (crew: Crew) => void = () => undefined;
    const loading = new Promise<Crew>((resolve) => (loaded = resolve));
    const changes = new LaneChanges();
    vi.spyOn(changes, 'lanesOf').mockResolvedValue(null);
    const kernel = new PageKernel(changes, () => loading, 10);
    const run = () => kernel.run(made, question({}), null, 4, AbortSignal.timeout(1000));
    for (let asks = 0; asks < 2; asks++) {
      await expect(run()).rejects.toEqual(new Obstacle('the kernel of the page is still loading'));
    }
    loaded(await Crew.of({} as WebAssembly.Module, [made.port(0), made.port(1)]));
    expect((await run()).duration).toBe(5);
  });

  it('everything in a browser without WebAssembly', async () => {
    const kernel = new PageKernel(new LaneChanges(), () => Promise.reject(new Error('no SIMD')));
    const asks = kernel.run(made, question({}), null, 4, AbortSignal.timeout(1000));
    await expect(asks).rejects.toEqual(new Obstacle('no SIMD'));
  });
});
