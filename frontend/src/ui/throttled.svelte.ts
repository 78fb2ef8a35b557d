import { Pace } from './throttle';

/** Returns what `read` gives at the pace of numbers; to be called where a component is made. */
export function calm<T>(read: () => T): { readonly current: T } {
  let current = $state.raw(read());
  const pace = new Pace<T>((value) => (current = value));
  // What is offered is taken back when the next one is, or when the component goes.
  $effect(() => pace.offer(read()));
  return {
    get current() {
      return current;
    },
  };
}
