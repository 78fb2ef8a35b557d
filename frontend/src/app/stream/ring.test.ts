import { describe, expect, it } from 'vitest';
import { Ring } from './ring';

function ramp(from: number, count: number): Float32Array {
  return Float32Array.from({ length: count }, (_, i) => from + i);
}

function reduce(ring: Ring, name: string, from: number, size: number, bins: number) {
  const minimum = new Float32Array(bins);
  const maximum = new Float32Array(bins);
  ring.reduce(name, from, size, bins, minimum, maximum);
  return { minimum: [...minimum], maximum: [...maximum] };
}

describe('Ring', () => {
  it('holds the last samples by tick', () => {
    const ring = new Ring(64, ['p']);
    for (let tick = 1000; tick < 1100; tick += 10) ring.write(tick, [ramp(tick, 10)]);
    expect([ring.start, ring.end]).toEqual([1036, 1100]);
    expect(ring.at('p', 1099)).toBe(1099);
    expect(ring.at('p', 1036)).toBe(1036);
    expect(ring.at('p', 1035)).toBeNaN();
    expect(ring.at('p', 1100)).toBeNaN();
    expect(ring.at('q', 1099)).toBeNaN();
  });

  it('reduces by blocks to what the samples say', () => {
    const ring = new Ring(128, ['p']);
    const values = Float32Array.from({ length: 300 }, (_, i) => Math.sin(i) * i);
    for (let tick = 0; tick < 300; tick += 7) ring.write(tick, [values.slice(tick, tick + 7)]);
    const { minimum, maximum } = reduce(ring, 'p', 192, 32, 3);
    for (let bin = 0; bin < 3; bin++) {
      const part = values.slice(192 + 32 * bin, 192 + 32 * (bin + 1));
      expect(minimum[bin]).toBe(Math.min(...part));
      expect(maximum[bin]).toBe(Math.max(...part));
    }
  });

  it('keeps a spike of one tick', () => {
    const ring = new Ring(1024, ['p']);
    const values = new Float32Array(1000);
    values[777] = 5;
    ring.write(0, [values]);
    expect(Math.max(...reduce(ring, 'p', 0, 64, 15).maximum)).toBe(5);
  });

  it('holds samples that stand for several ticks, and the middle of a difference', () => {
    const ring = new Ring(64, ['A.x.thrust', 'B.x.thrust']);
    ring.write(0, [new Float32Array([3, -1, 2, 2]), new Float32Array([0, 2, 1, 1])], 4);
    expect([ring.start, ring.end]).toEqual([0, 16]);
    expect([0, 3, 4, 7, 8].map((tick) => ring.at('A.x.thrust', tick))).toEqual([3, 3, -1, -1, 2]);
    const difference = Array.from({ length: 16 }, (_, tick) => ring.at('A-B.x.thrust', tick));
    expect(difference).toEqual([...Array<number>(8).fill(0), ...Array<number>(8).fill(1)]);
    const { minimum, maximum } = reduce(ring, 'A.x.thrust', 0, 16, 1);
    expect([minimum[0], maximum[0]]).toEqual([-1, 3]);
  });

  it('leaves skipped ticks empty', () => {
    const ring = new Ring(256, ['p']);
    ring.write(0, [ramp(0, 64)]);
    ring.write(128, [ramp(128, 64)]);
    expect(ring.at('p', 100)).toBeNaN();
    const { minimum } = reduce(ring, 'p', 0, 32, 6);
    expect(minimum).toEqual([0, 32, Number.NaN, Number.NaN, 128, 160]);
  });

  it('starts anew after a jump longer than itself, and when it goes back', () => {
    const ring = new Ring(64, ['p']);
    ring.write(0, [ramp(0, 10)]);
    ring.write(1000, [ramp(1000, 10)]);
    expect([ring.start, ring.end]).toEqual([1000, 1010]);
    ring.write(5, [ramp(5, 5)]);
    expect([ring.start, ring.end]).toEqual([5, 10]);
  });

  it('overwrites what is sent again', () => {
    const ring = new Ring(64, ['p']);
    ring.write(0, [ramp(0, 20)]);
    ring.write(10, [ramp(50, 5)]);
    expect([ring.at('p', 9), ring.at('p', 10), ring.at('p', 19)]).toEqual([9, 50, 19]);
    expect(ring.end).toBe(20);
  });

  it('takes in late what was skipped, with differences and extremes, and leaves the rest', () => {
    const late = new Ring(256, ['A.e', 'B.e']);
    const whole = new Ring(256, ['A.e', 'B.e']);
    const a = Float32Array.from({ length: 700 }, (_, i) => Math.sin(i) * i);
    const b = Float32Array.from({ length: 700 }, (_, i) => Math.cos(i) * i);
    const part = (from: number, to: number) => [a.slice(from, to), b.slice(from, to)];
    whole.write(0, [a, b]);
    late.write(0, part(0, 500));
    late.write(620, part(620, 700));
    expect(late.at('A-B.e', 550)).toBeNaN();
    // Out of order, in pieces, and beyond what is missing on both sides.
    late.patch(560, part(560, 640));
    late.patch(300, part(300, 570));
    for (const name of ['A.e', 'B.e', 'A-B.e']) {
      for (let tick = 440; tick < 710; tick++) {
        expect(late.at(name, tick)).toEqual(whole.at(name, tick));
      }
      for (const [from, size] of [
        [441, 7],
        [448, 16],
        [448, 32],
      ] as const) {
        expect(reduce(late, name, from, size, 8)).toEqual(reduce(whole, name, from, size, 8));
      }
    }
    expect([late.start, late.end]).toEqual([444, 700]);
  });

  it('does not go back or on with what comes late', () => {
    const ring = new Ring(64, ['p']);
    ring.write(1000, [ramp(1000, 100)]);
    const { version } = ring;
    ring.patch(900, [ramp(900, 100)]);
    ring.patch(1100, [ramp(1100, 10)]);
    expect([ring.start, ring.end, ring.version]).toEqual([1036, 1100, version]);
    ring.patch(1090, [ramp(0, 100)]);
    expect([ring.end, ring.at('p', 1090), ring.at('p', 1099)]).toEqual([1100, 0, 9]);
  });

  it('takes a frame longer than itself', () => {
    const ring = new Ring(64, ['p']);
    ring.write(0, [ramp(0, 200)]);
    expect([ring.start, ring.end, ring.at('p', 136), ring.at('p', 199)]).toEqual([
      136, 200, 136, 199,
    ]);
  });

  it('computes differences as samples arrive', () => {
    const ring = new Ring(64, ['A.e', 'B.e']);
    ring.write(0, [ramp(10, 5), ramp(3, 5)]);
    expect(ring.at('A-B.e', 4)).toBe(7);
  });

  it('forgets on clear', () => {
    const ring = new Ring(64, ['p']);
    ring.write(0, [ramp(0, 20)]);
    ring.clear();
    expect(ring.at('p', 3)).toBeNaN();
    expect(reduce(ring, 'p', 0, 16, 1).minimum).toEqual([Number.NaN]);
  });
});
