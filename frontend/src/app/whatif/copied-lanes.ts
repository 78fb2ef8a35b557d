/** Lane parameters of a change that needs no check but that of its range: the page makes them. */

import { type Lanes, withFields } from '../../kernel/lanes';
import type { Inputs } from '../../kernel/tasks';
import type { Range } from '../../plot/source';
import { equal } from '../api/scenario-paths';
import type { Question } from './whatif.svelte';

/** A question that the server has checked, and its numbers. */
export interface Checked {
  question: Question;
  lanes: Lanes;
  inputs: Inputs;
}

/**
 * Returns the numbers of a question that differs from a checked one in copied fields only, each in its
 * range; null where the server has to check it.
 */
export function copiedLanes(
  { question: before, lanes, inputs }: Checked,
  question: Question,
  range: Range | null,
): Checked | null {
  if (before.scenario !== question.scenario || !reaches(lanes, range)) return null;
  if (Object.keys(before.set).some((path) => !(path in question.set))) return null;
  const changed = Object.entries(question.set).filter(
    ([path, value]) => !equal(before.set[path], value),
  );
  const numbers = withFields(lanes, changed);
  if (!numbers) return null;
  return { question, lanes: { ...lanes, lanes: numbers }, inputs };
}

/** Whether a run goes over a stretch of time as far as the scenario does. */
function reaches({ how, first, stop, period }: Lanes, range: Range | null): boolean {
  if (!range || how === 'whole') return true;
  return first * period <= range.from && range.to <= stop * period;
}
