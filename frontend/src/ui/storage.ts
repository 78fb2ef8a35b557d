/** Small things that outlive a reload. A browser that forbids storage loses them, and nothing else. */

const PREFIX = 'motionlab.';

export function load<T>(key: string, fallback: T): T {
  try {
    const text = localStorage.getItem(PREFIX + key);
    return text === null ? fallback : (JSON.parse(text) as T);
  } catch {
    return fallback;
  }
}

export function save(key: string, value: unknown): void {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // Full or forbidden: the page works without.
  }
}

/** Puts parameters into the address, so that a reload or a copied link finds the same view. */
export function setAddress(parameters: Record<string, string>): void {
  const url = new URL(location.href);
  for (const [key, value] of Object.entries(parameters)) url.searchParams.set(key, value);
  if (url.href !== location.href) history.replaceState(null, '', url);
}

export function fromAddress(key: string): string | null {
  return new URL(location.href).searchParams.get(key);
}
