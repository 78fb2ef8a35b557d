import { Throttle } from './throttle';

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
