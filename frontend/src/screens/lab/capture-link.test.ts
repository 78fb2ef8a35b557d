import { expect, it, vi } from 'vitest';

vi.hoisted(() => vi.stubGlobal('location', new URL('http://lab/'))); // before the modules read it
import type { Capture } from '../../scopes/trigger/captures';
import { captureParameters } from './capture-link';

const capture = (key: string, first: number, tick: number, run: string) =>
  ({ key, ticks: [first, first + 400], tick, time: tick * 0.0005, run }) as unknown as Capture;

it('the run of a capture begins at 0 s, and so do cursors and what lies behind it', () => {
  const shown = capture('1', 40400, 40500, 'r-shown');
  const before = capture('2', 37300, 37450, 'r-before');
  const view = {
    period: 0.0005,
    subject: 'B',
    axis: 'x',
    zoom: null,
    cursors: [20.25, 20.3],
    levels: {},
    statistic: 'value',
    measuring: true,
    layout: { parameters: { scopes: 'A.x.thrust', layout: '', open: '' } },
    trigger: { all: [shown, before], overlaid: ['2'] },
  } as unknown as Parameters<typeof captureParameters>[0];
  const overlaid = [{ id: 'r-circle', offset: 12, shown: true }];
  const { curves, ...rest } = captureParameters(view, shown, overlaid);
  expect(rest).toEqual({
    screen: 'runs',
    run: 'r-shown',
    large: 'r-shown',
    // Triggered 75 ms after its begin, the other one 50 ms after.
    overlay: 'r-circle:-8.2,r-before:-0.025',
  });
  expect(JSON.parse(curves)).toEqual({
    cursors: [0.05, 0.1],
    measuring: true,
    at: 0.1,
    of: ['B', 'x'],
    scopes: 'A.x.thrust',
    layout: '',
    open: '',
  });
});
