/** The one animation-frame loop: everything that draws curves is called here, once a frame. */

type Draw = (now: number) => void;

/** ms without anything drawn, touched or rebuilt after which the loop rests. */
const AWAKE = 300;
/** ms from one look at whether there is something to draw to the next, while it rests. */
const REST = 100;
const HANDS = ['pointerdown', 'pointermove', 'pointerup', 'wheel', 'keydown', 'dragover'];

class Loop {
  /** Frames since the start, and ms of script spent in them; who reads them takes differences. */
  readonly counts = { frames: 0, script: 0 };
  private readonly drawers = new Set<Draw>();
  private running = false;
  private stirred = 0;
  private rest: ReturnType<typeof setTimeout> | undefined;
  private watching = false;

  /** Calls `draw` once a frame, less often at rest, until the returned function is called. */
  add(draw: Draw): () => void {
    this.drawers.add(draw);
    this.watch();
    this.stir();
    if (!this.running) {
      this.running = true;
      requestAnimationFrame(this.frame);
    }
    return () => this.drawers.delete(draw);
  }

  /** Something is drawn, so there may be something to draw in the next frame too. */
  stir = (): void => {
    this.stirred = performance.now();
    if (this.rest === undefined) return;
    clearTimeout(this.rest);
    this.rest = undefined;
    requestAnimationFrame(this.frame);
  };

  /** Hands, and a page that is rebuilt, come before what is drawn. */
  private watch(): void {
    if (this.watching) return;
    this.watching = true;
    for (const each of HANDS) addEventListener(each, this.stir, { capture: true, passive: true });
    // Not texts: the status line has new figures every second.
    const all = { subtree: true, childList: true, attributes: true };
    new MutationObserver(this.stir).observe(document, all);
  }

  private readonly frame = (now: number): void => {
    if (this.drawers.size === 0) {
      this.running = false;
      return;
    }
    const begin = performance.now();
    for (const draw of this.drawers) draw(now);
    const end = performance.now();
    this.counts.frames += 1;
    this.counts.script += end - begin;
    if (end - this.stirred < AWAKE) requestAnimationFrame(this.frame);
    else this.rest = setTimeout(this.look, REST);
  };

  private readonly look = (): void => {
    this.rest = undefined;
    requestAnimationFrame(this.frame);
  };
}

export const loop = new Loop();
