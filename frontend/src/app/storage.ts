/** Small things that outlive a reload. A browser that forbids storage loses them, and nothing else. */

const PREFIX = 'motionlab.';
/** Where a tab keeps its control of the drives over a reload, in sessionStorage. */
export const LEASE = 'motionlab.lease';

/**
 * The form of a kept value: an example, a test, or an object or a tuple of forms. Null is any value.
 * Keys beyond those of an object are allowed.
 */
export type Form = unknown;
type Test = (value: unknown) => boolean;

export const oneOf =
  (...values: readonly unknown[]): Test =>
  (value) =>
    values.includes(value);

export const nullOr =
  (form: Form): Test =>
  (value) =>
    value === null || alike(value, form);

export const listOf =
  (form: Form): Test =>
  (value) =>
    Array.isArray(value) && value.every((item) => alike(item, form));

/** An object with any keys. */
export const recordOf =
  (form: Form): Test =>
  (value) =>
    alike(value, {}) && Object.values(value as object).every((entry) => alike(entry, form));

/** An object that may lack keys. */
export const partOf =
  (forms: Record<string, Form>): Test =>
  (value) =>
    alike(value, {}) &&
    Object.entries(value as object).every(([key, entry]) => alike(entry, forms[key] ?? null));

/** Returns what was kept, or `fallback` where that is damaged or not of the form. */
export function load<T>(key: string, fallback: T, form: Form = fallback): T {
  try {
    return parsed(localStorage.getItem(PREFIX + key), fallback, form);
  } catch {
    return fallback; // forbidden
  }
}

/** Returns the value of a text that was kept, or `fallback` as `load` does. */
export function parsed<T>(text: string | null, fallback: T, form: Form = fallback): T {
  try {
    const kept: unknown = text === null ? null : JSON.parse(text);
    return text !== null && alike(kept, form) ? (kept as T) : fallback;
  } catch {
    return fallback;
  }
}

function alike(value: unknown, form: Form): boolean {
  if (form === null) return true;
  if (typeof form === 'function') return (form as Test)(value);
  if (typeof value !== typeof form || value === null) return false;
  if (Array.isArray(value) !== Array.isArray(form)) return false;
  if (typeof form !== 'object') return true;
  if (Array.isArray(form) && form.length !== (value as unknown[]).length) return false;
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
