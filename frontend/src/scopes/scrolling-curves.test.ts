import { afterEach, expect, it, vi } from 'vitest';
import { Ring } from '../app/stream/ring';
import { AxisScale } from '../plot/axis-scale';
import { ScrollingCurves } from '../plot/scrolling-curves';
import { recorder } from '../plot/recorder';
import { SourceCurve } from '../plot/source-curve';
import { LiveSource } from './live-source';

const PIXELS: [number, number] = [0, 100];

afterEach(() => vi.unstubAllGlobals());

function samples(tick: number, count: number): Float32Array {
  return Float32Array.from({ length: count }, (_, i) => Math.sin((tick + i) / 40) + (((tick + i) * 7) % 5) / 50); // prettier-ignore
}

/** A ring, a picture of its newest stretch, and how many bins of it were kept when drawn. */
function scene(span: number, capacity = 4096) {
  const ring = new Ring(capacity, ['p']);
  const source = new LiveSource(
    () => ring,
    () => 1,
  );
  const [whole, layer, { canvas, calls }] = [recorder(), recorder(), recorder()];
  vi.stubGlobal('devicePixelRatio', 1);
  vi.stubGlobal('document', { createElement: () => layer.canvas.element });
  vi.stubGlobal('getComputedStyle', () => ({ fontFamily: '' }));
  const picture = new ScrollingCurves(whole.canvas);
  const curve = new SourceCurve('p', { dash: 'dash' });
  const y = new AxisScale({ label: '' }, -1, 1, [50, 0]);
  const shown = (curve: SourceCurve, x: AxisScale) => {
    calls.length = 0;
    curve.draw(canvas, source, x, y);
    // Which extreme of the first bin comes first depends on the bin before it, if that was read.
    return calls.filter(([name]) => name === 'moveTo' || name === 'lineTo').slice(2);
  };
  function draw(): number {
    const [from, to] = picture.snapped({ from: ring.end - span, to: ring.end }, 100);
    const x = new AxisScale({ label: '' }, from, to, PIXELS);
    const bins = source.cut(from, to, 100);
    const kept = picture.kept(source, bins);
    const ends = curve.read(source, bins, kept);
    picture.draw(source, [{ curves: [curve], y }], x, bins, kept);
    const fresh = new SourceCurve('p', { dash: 'dash' });
    expect(ends).toEqual(fresh.read(source, bins));
    expect(shown(curve, x)).toEqual(shown(fresh, x));
    return kept / bins.count;
  }
  return { ring, draw };
}

it.each([90, 100, 1000, 1600])(
  'what is read bit by bit over %i samples is what is there',
  (span) => {
    const { ring, draw } = scene(span);
    let kept = 0;
    for (let [tick, i] = [0, 0]; tick < 6000; i++) {
      const count = 1 + ((i * 31) % 47);
      ring.write(tick, [samples(tick, count)]);
      tick += count;
      kept += draw();
    }
    expect(kept).toBeGreaterThan(100);
  },
);

it('samples that come late, again or after a gap are drawn', () => {
  const { ring, draw } = scene(1000);
  ring.write(0, [samples(0, 2000)]);
  expect(draw()).toBe(0);
  expect(draw()).toBeGreaterThan(0.9);
  ring.write(2100, [samples(2100, 10)]);
  expect(draw()).toBeGreaterThan(0.8);
  ring.patch(2000, [samples(2000, 100)]);
  expect(draw()).toBe(0);
  ring.write(2050, [samples(9, 60)]);
  expect(draw()).toBe(0);
  ring.clear();
  ring.write(0, [samples(0, 2000)]);
  expect(draw()).toBe(0);
});

it('what the ring has forgotten is drawn no more', () => {
  const { ring, draw } = scene(1000, 1008);
  for (let tick = 0; tick < 4000; tick += 50) {
    ring.write(tick, [samples(tick, 50)]);
    draw();
  }
});
