/** The overlaid runs as the address carries them: `r-1,r-2:1.5,r-3:0:hidden`. */

export interface Placed {
  id: string;
  /** Added to the times of the run, s. */
  offset: number;
  shown: boolean;
}

/** Most runs at once: more kinds of dashes could not be told apart. */
export const MOST = 4;

export function writeOverlay(runs: readonly Placed[]): string {
  return runs
    .map(({ id, offset, shown }) => {
      if (!shown) return `${id}:${offset}:hidden`;
      return offset === 0 ? id : `${id}:${offset}`;
    })
    .join();
}

/** Reads the address; what is not understood is left out. */
export function readOverlay(text: string): Placed[] {
  const overlaid: Placed[] = [];
  for (const part of text.split(',')) {
    const [id = '', offset = '0', hidden = ''] = part.split(':');
    const known = overlaid.some((placed) => placed.id === id);
    if (!/^[\w-]+$/.test(id) || known || overlaid.length === MOST) continue;
    overlaid.push({
      id,
      offset: Number.isFinite(Number(offset)) ? Number(offset) : 0,
      shown: hidden !== 'hidden',
    });
  }
  return overlaid;
}
