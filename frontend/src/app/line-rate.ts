/** How fast the line to the server is, from what came over it. */

/** Bytes from which an answer says something about the line. */
const LEAST = 20_000;
/** Answers that are sent in one piece once they are there. */
const WHOLE = /\.(js|css|wasm)$|\/whatif$/;

let latest = Number.POSITIVE_INFINITY;

/** Takes in an answer: bytes that were transferred, and the time they took, ms. */
export function noteTransfer(name: string, bytes: number, duration: number): void {
  const { pathname } = new URL(name);
  if (bytes >= LEAST && WHOLE.test(pathname)) latest = (1000 * bytes) / Math.max(duration, 1);
}

/** Takes in the rate of a stream that is all the line carries, bytes/s. */
export function noteRate(rate: number): void {
  latest = rate;
}

/** Rate of the newest answer, bytes/s; infinite before there is one. */
export function lineRate(): number {
  return latest;
}

/** Watches what comes, and what has come already; returns what ends that. */
export function watchLine(): () => void {
  const observer = new PerformanceObserver((list) => {
    for (const entry of list.getEntries() as PerformanceResourceTiming[]) {
      noteTransfer(entry.name, entry.transferSize, entry.responseEnd - entry.responseStart);
    }
  });
  observer.observe({ type: 'resource', buffered: true });
  return () => observer.disconnect();
}
