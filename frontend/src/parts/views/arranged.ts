/** How plots are arranged in a place, so that each can be read. */

/** Least size of a plot with its legend, CSS pixels. */
const LEAST = { width: 250, height: 170 };
/** Width over height of a plot that is read well. */
const SHAPE = 1.7;

/** Returns how many of some plots fit, and in how many columns: those that come out largest. */
export function arranged(plots: number, width: number, height: number) {
  for (let count = plots; count > 1; count--) {
    const grids = Array.from({ length: count }, (_, i) => {
      const columns = i + 1;
      const [wide, high] = [width / columns, height / Math.ceil(count / columns)];
      const fits = wide >= LEAST.width && high >= LEAST.height;
      return { count, columns, size: fits ? Math.min(wide / SHAPE, high) : 0 };
    });
    const best = grids.reduce((a, b) => (b.size > a.size ? b : a));
    if (best.size > 0) return { count, columns: best.columns };
  }
  return { count: 1, columns: 1 };
}
