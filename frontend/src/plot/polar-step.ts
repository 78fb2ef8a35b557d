/** The distance of rings: 1, 2 or 5 times a power of ten, no less than asked for. */
export function niceStep(least: number): number {
  if (!(least > 0)) return 1e-9;
  const power = 10 ** Math.floor(Math.log10(least) + 1e-9);
  const step = [1, 2, 5, 10].find((each) => each * power >= least * (1 - 1e-9)) ?? 10;
  return step * power;
}
