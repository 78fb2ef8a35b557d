/** How long to wait before each further attempt to connect: doubling, bounded, a little scattered. */
export class Backoff {
  private failures = 0;

  constructor(
    private readonly first = 250,
    private readonly longest = 5000,
    private readonly random: () => number = Math.random,
  ) {}

  /** Returns the milliseconds until the next attempt and counts it. */
  next(): number {
    const wait = Math.min(this.longest, this.first * 2 ** this.failures);
    this.failures += 1;
    // Scattered, so that all pages of a restarted server do not come at the same instant.
    return wait * (0.8 + 0.4 * this.random());
  }

  /** Clears the failures once connected. */
  reset(): void {
    this.failures = 0;
  }
}
