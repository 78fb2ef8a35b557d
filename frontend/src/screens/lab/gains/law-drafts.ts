/** Texts of laws that are being changed in the page and not saved: they outlive the sheet. */

import { SvelteMap } from 'svelte/reactivity';
import type { LawEntry } from '../../../app/api/types';

export interface Draft {
  /** What the file held when its text was opened, and its digest: later versions are none of it. */
  before: string;
  digest: string;
  text: string;
}

export const drafts = new SvelteMap<string, Draft>();

export function openDraft({ name, text, digest }: LawEntry): void {
  drafts.set(name, { before: text, digest, text });
}
