/** Where playing a record gets to. */

export const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 5, 10] as const;

/** Longest step of one frame, s: a page in the background does not jump ahead. */
const FRAME = 0.25;

/** Returns the moment after `elapsed` seconds of playing, and whether that is the end. */
export function advanced(
  time: number,
  { elapsed, speed, end }: { elapsed: number; speed: number; end: number },
): { time: number; ended: boolean } {
  const next = time + Math.min(elapsed, FRAME) * speed;
  return next >= end ? { time: end, ended: true } : { time: next, ended: false };
}

/** Returns the speed that is so many steps faster, within those that there are. */
export function otherSpeed(speed: number, steps: number): number {
  const at = SPEEDS.findIndex((each) => each >= speed);
  const next = Math.min(SPEEDS.length - 1, Math.max(0, at + steps));
  return SPEEDS[next] ?? 1;
}
