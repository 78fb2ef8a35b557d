import { Throttle } from './throttle';

/** Returns what `read` gives at the pace of numbers; to be called where a component is made. */
export function throttled<T>(read: () => T): { readonly current: T } {
  let current = $state.raw(read());
  const throttle = new Throttle<T>((value) => (current = value));
  // What is offered is taken back when the next one is, or when the component goes.
  $effect(() => throttle.offer(read()));
  return {
    get current() {
      return current;
    },
  };
}
