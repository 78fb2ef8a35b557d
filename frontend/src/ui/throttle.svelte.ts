/** Numbers on the screen change at most ten times a second, so that they can be read, ms. */
const PAUSE = 100;

/** Passes values on: the first at once, and of those soon after it the newest, once. */
export class Throttle<T> {
  private since = Number.NEGATIVE_INFINITY;

  constructor(private readonly take: (value: T) => void) {}

  /** Takes a value now, or later unless the returned function is called before. */
  offer(value: T): () => void {
    const pass = () => {
      this.since = performance.now();
      this.take(value);
    };
    const left = this.since + PAUSE - performance.now();
    if (left <= 0) pass();
    const timer = left > 0 ? setTimeout(pass, left) : undefined;
    return () => clearTimeout(timer);
  }
}

/** Returns what `read` gives at the pace of numbers; to be called where a component is made. */
export function throttled<T>(read: () => T): { readonly current: T } {
  let current = $state.raw(read());
  const throttle = new Throttle<T>((value) => (current = value));
  // An offer is withdrawn for the next one, or when the component is destroyed.
  $effect(() => throttle.offer(read()));
  return {
    get current() {
      return current;
    },
  };
}
