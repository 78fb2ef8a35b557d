/** Small things that outlive a reload. A browser that forbids storage loses them, and nothing else. */

const PREFIX = 'motionlab.';

/** Returns what was kept, or `fallback` where that is damaged or of another form. */
export function load<T>(key: string, fallback: T): T {
  try {
    const text = localStorage.getItem(PREFIX + key);
    const kept: unknown = text === null ? null : JSON.parse(text);
    return alike(kept, fallback) ? (kept as T) : fallback;
  } catch {
    return fallback;
  }
}

/** Whether a value has the form of `form`, and every entry that it has; null is any form. */
function alike(value: unknown, form: unknown): boolean {
  if (form === null) return true;
  if (typeof value !== typeof form || value === null) return false;
  if (Array.isArray(value) !== Array.isArray(form)) return false;
  if (typeof form !== 'object') return true;
  const entries = value as Record<string, unknown>;
  return Object.entries(form as object).every(([key, entry]) => alike(entries[key], entry));
}

export function save(key: string, value: unknown): void {
  try {
    localStorage.setItem(PREFIX + key, JSON.stringify(value));
  } catch {
    // Full or forbidden: the page works without.
  }
}

export function discard(key: string): void {
  try {
    localStorage.removeItem(PREFIX + key);
  } catch {
    // Forbidden: nothing was kept either.
  }
}

/** Puts parameters into the address, so that a reload or a copied link finds the same view; '' goes. */
export function setAddress(parameters: Record<string, string>): void {
  const url = new URL(location.href);
  for (const [key, value] of Object.entries(parameters)) {
    if (value === '') url.searchParams.delete(key);
    else url.searchParams.set(key, value);
  }
  if (url.href !== location.href) history.replaceState(null, '', url);
}

export function fromAddress(key: string): string | null {
  return new URL(location.href).searchParams.get(key);
}
