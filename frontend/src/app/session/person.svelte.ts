/** Who uses this browser: the name that was given, and the one by which others see it. */

import { load, save } from '../storage';

const NAME = 'person.name';
const KEY = 'person.key';
/** Of a nameless person, at the drives. */
const BROWSER = 'drive-name';
/** Characters that the server shows of a name. */
export const NAME_MAX = 40;

function keptKey(): string {
  const key = load(KEY, '');
  if (/^[\w-]{1,64}$/.test(key)) return key;
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  const made = Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
  save(KEY, made);
  return made;
}

function keptBrowser(): string {
  const kept = load(BROWSER, '');
  if (kept !== '') return kept;
  const made = `browser ${Math.random().toString(16).slice(2, 6)}`;
  save(BROWSER, made);
  return made;
}

class Person {
  /** Empty for a guest. */
  name = $state(load(NAME, ''));
  /** By which others see it in this session; empty until the server has answered. */
  seen = $state('');
  /** In place of a name where several sessions meet, such as at the drives: guests' numbers are of one. */
  readonly browser = keptBrowser();
  private readonly key = keptKey();
  private readonly names = new Set<string>();

  /** What streams say of it. */
  get message(): { name: string; key: string } {
    return { name: this.name, key: this.key };
  }

  /** By which others know it in any session. */
  get anywhere(): string {
    return this.name || this.browser;
  }

  /** The header of what it does. */
  get header(): Record<string, string> {
    return this.seen === '' ? {} : { Person: encodeURIComponent(this.seen) };
  }

  rename(name: string): void {
    this.name = [...name.trim()].slice(0, NAME_MAX).join('');
    save(NAME, this.name);
  }

  /** Takes the name by which others see it; in another session that is another guest's. */
  take(seen: string): void {
    this.seen = seen;
    this.names.add(seen);
  }

  /** Comes to another session. */
  enter(): void {
    this.seen = '';
    this.names.clear();
  }

  /** " by" and the name where somebody else did it; empty for one's own and where there is no name. */
  other(by: string | undefined): string {
    return by === undefined || by === '' || this.names.has(by) ? '' : ` by ${by}`;
  }
}

export const person = new Person();
