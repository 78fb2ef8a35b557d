/** Objectives and limits of a sweep as a person edits them. */

import { listOf, load, save } from '../../app/storage';
import { clean, digits, parseNumber } from '../../ui/units';
import { boundOf, partsOf } from './figures';
import { KEPT_LIMITS, type LimitEntry } from './sweep-form';

const FIRST = ['B.worst.max_abs_following_error', 'B.worst.gain_margin'];
const FIRST_LIMIT: LimitEntry = { of: 'B.worst.gain_margin', by: 'at_least', value: '6' };

export class Criteria {
  objectives = $state.raw<readonly string[]>(load('sweep.objectives', [], listOf('')));
  limits = $state.raw<readonly LimitEntry[]>(load('sweep.limits', [], KEPT_LIMITS));
  private readonly numbers = $derived(this.limits.map(({ value }) => parseNumber(value)));
  /** Limits whose values are no numbers. */
  readonly wrong = $derived(this.numbers.flatMap((number, k) => (number === null ? [k] : [])));

  /** @param edited called when something has changed */
  constructor(private readonly edited: () => void) {}

  /** The part of the request; null where a value is no number. */
  body(): { objectives: readonly string[]; limits: object[] } | null {
    if (this.wrong.length > 0) return null;
    const limits = this.limits.map(({ of, by }, k) => {
      const bound = boundOf(partsOf(of).metric);
      return { of, [by]: clean(bound.si(this.numbers[k] as number)) };
    });
    return { objectives: this.objectives, limits };
  }

  /** Takes those of a request. */
  restore({ objectives, limits }: Record<string, unknown>): void {
    const entries = (limits ?? []) as (Partial<Record<LimitEntry['by'], number>> & {
      of: string;
    })[];
    const of = ({ of, ...bounds }: (typeof entries)[number]): LimitEntry[] =>
      (['at_least', 'at_most'] as const).flatMap((by) => {
        const value = bounds[by];
        if (value === undefined || value === null) return [];
        return [{ of, by, value: digits(boundOf(partsOf(of).metric).of(value), 6) }];
      });
    this.take((objectives ?? []) as string[], entries.flatMap(of));
  }

  add(): void {
    const next = FIRST.find((name) => !this.objectives.includes(name)) ?? FIRST[0];
    this.take([...this.objectives, next as string], this.limits);
  }

  addLimit(): void {
    this.take(this.objectives, [...this.limits, FIRST_LIMIT]);
  }

  objective(index: number, name: string | null): void {
    this.take(replaced(this.objectives, index, name), this.limits);
  }

  limit(index: number, changes: Partial<LimitEntry> | null): void {
    const former = this.limits[index] ?? FIRST_LIMIT;
    const next = changes && { ...former, ...changes };
    this.take(this.objectives, replaced(this.limits, index, next));
  }

  private take(objectives: readonly string[], limits: readonly LimitEntry[]): void {
    [this.objectives, this.limits] = [objectives, limits];
    save('sweep.objectives', objectives);
    save('sweep.limits', limits);
    this.edited();
  }
}

/** A list with another item at a place, or without it. */
function replaced<T>(list: readonly T[], index: number, item: T | null): readonly T[] {
  return list.flatMap((each, k) => (k !== index ? [each] : item === null ? [] : [item]));
}
