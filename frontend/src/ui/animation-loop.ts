/** The one animation-frame loop: everything that draws curves is called here, once a frame. */

type Draw = (now: number) => void;

class Loop {
  /** Frames since the start, and ms of script spent in them; who reads them takes differences. */
  readonly counts = { frames: 0, script: 0 };
  private readonly drawers = new Set<Draw>();
  private running = false;

  /** Calls `draw` once a frame until the returned function is called. */
  add(draw: Draw): () => void {
    this.drawers.add(draw);
    if (!this.running) {
      this.running = true;
      requestAnimationFrame(this.frame);
    }
    return () => this.drawers.delete(draw);
  }

  private readonly frame = (now: number): void => {
    if (this.drawers.size === 0) {
      this.running = false;
      return;
    }
    const begin = performance.now();
    for (const draw of this.drawers) draw(now);
    this.counts.frames += 1;
    this.counts.script += performance.now() - begin;
    requestAnimationFrame(this.frame);
  };
}

export const loop = new Loop();
