/** For tests: a canvas that writes down what is drawn. */

import { vi } from 'vitest';
import { Canvas } from './canvas';
import type { Palette } from './palette';

export type Call = [name: string, ...args: number[]];

export function recorder(width = 400, height = 300): { canvas: Canvas; calls: Call[] } {
  vi.stubGlobal('getComputedStyle', () => ({ fontFamily: 'sans-serif' }));
  vi.stubGlobal('devicePixelRatio', 1);
  const calls: Call[] = [];
  const context = new Proxy({} as Record<string, unknown>, {
    get: (own, name: string) =>
      name in own ? own[name] : (...args: number[]) => void calls.push([name, ...args]),
  });
  const element = { getContext: () => context } as unknown as HTMLCanvasElement;
  const canvas = new Canvas(element, {} as Palette);
  canvas.resize(width, height);
  vi.unstubAllGlobals();
  return { canvas, calls };
}
