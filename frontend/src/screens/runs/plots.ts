/** The curves that the keys of the screen act on. */

/** Curves over an axis that can be zoomed and moved along. */
export interface Zoomed {
  zoomBy(ratio: number): void;
  /** By a share of what is shown. */
  moveBy(share: number): void;
  reset(): void;
  /** With the cursor to the next peak, or the one before. */
  nextPeak?(way: 1 | -1): Promise<void>;
  /** To the next place beyond a tolerance, or the one before. */
  excursion?(way: 1 | -1): void;
}

export const plots: { current: Zoomed | null } = { current: null };
