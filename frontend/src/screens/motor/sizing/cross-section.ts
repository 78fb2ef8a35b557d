/** The cross-section of one mover over the stator, to scale where the equations give a length. */

export interface Teeth {
  tau: number;
  p: number;
  s: number;
  n: number;
  limbs: number;
  g: number;
}

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export interface Section {
  /** Width of the mover, m. */
  w: number;
  /** Boxes in m, y downwards from the face of the mover's teeth. */
  teeth: Box[];
  shoes: Box[];
  limbs: Box[];
  yoke: Box;
  coils: Box[];
  stator: Box[];
  back: Box;
  /** What is drawn around it all. */
  frame: Box;
}

/**
 * Heights are no part of the equations: tooth depth, shoe, window and yoke are drawn in the
 * proportion of the finite-element model, as shares of the tooth width.
 */
export function section({ tau, p, s, n, limbs, g }: Teeth): Section {
  const w = limbs * n * tau - s;
  const shoe = n * tau - s;
  const [depth, shoeHeight, window, thick] = [p, 1.5 * p, 5 * p, 2.5 * p];
  const limbWidth = Math.min(shoe, 2.5 * p);
  const firsts = Array.from({ length: limbs }, (_, k) => k * n * tau);
  const box = (x: number, y: number, width: number, height: number): Box => ({
    x,
    y,
    width,
    height,
  });
  const outer = (first: number, k: number) =>
    limbs === 1 ? first + (shoe - limbWidth) / 2 : k === 0 ? first : first + shoe - limbWidth;
  const above = -depth - shoeHeight;
  const bodies = firsts.map((first, k) => box(outer(first, k), above - window, limbWidth, window));
  const inner = w - limbs * limbWidth;
  const coil = limbs === 1 ? 0 : Math.min(2.5 * p, 0.45 * inner);
  const beyond = tau;
  const count = Math.ceil((w + 2 * beyond) / tau) + 1;
  const frame = box(
    -beyond,
    above - window - thick,
    w + 2 * beyond,
    thick + window + shoeHeight + depth + g + 3.2 * p,
  );
  return {
    w,
    teeth: Array.from({ length: limbs * n }, (_, k) => box(k * tau, -depth, p, depth)),
    shoes: firsts.map((first) => box(first, above, shoe, shoeHeight)),
    limbs: bodies,
    yoke: box(
      bodies[0]?.x ?? 0,
      above - window - thick,
      (bodies.at(-1)?.x ?? 0) + limbWidth - (bodies[0]?.x ?? 0),
      thick,
    ),
    coils:
      coil === 0
        ? []
        : bodies.map((body, k) =>
            box(
              k === 0 ? body.x + limbWidth : body.x - coil,
              above - 0.95 * window,
              coil,
              0.9 * window,
            ),
          ),
    stator: Array.from({ length: count }, (_, k) => {
      const left = (k - 1) * tau;
      return box(left, g, Math.min(p, w + beyond - left), 1.5 * p);
    }).filter(({ width }) => width > 0.01 * p),
    back: box(-beyond, g + 1.5 * p, w + 2 * beyond, 1.7 * p),
    frame,
  };
}
