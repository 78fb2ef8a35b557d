/** Two runs compared: which, how, and what the server says. */

import { ApiError } from '../../../app/api/client';
import type { Comparison, RunDetail } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { LatestWins } from '../../../app/latest-wins';
import { fromAddress, setAddress } from '../../../app/storage';
import { compareRuns, getRun } from '../../../parts/runs/runs-api';
import { runs } from '../runs.svelte';
import { baseline } from '../baseline.svelte';
import {
  bodyOf,
  USUAL,
  howOf,
  lastBeforeStop,
  swapped,
  type How,
  type Rule,
} from '../../../parts/compare/compare-request';
import { lettersOf } from './compared-variants';
import {
  GRAVEST_FIRST,
  VERDICTS,
  type Sorting,
  type Verdict,
} from '../../../parts/compare/channel-verdicts';

/** What is drawn at first, where both have it. */
const FIRST = ['B.x.following_error', 'A.x.following_error', 'M.x.following_error'];

interface Question {
  a: string;
  b: string;
  how: How;
}

class ComparisonOfTwo {
  how = $state.raw<How>(USUAL);
  channel = $state('');
  verdict = $state<Verdict | ''>('');
  sorting = $state.raw<Sorting>(GRAVEST_FIRST);
  answer = $state.raw<Comparison | null>(null);
  busy = $state(false);
  /** What is wrong as a whole, and with one field of the request. */
  problem = $state('');
  fieldProblems = $state.raw<Readonly<Record<string, string>>>({});
  details = $state.raw<readonly RunDetail[]>([]);
  private opened = $state(false);
  /** The two that `how` was chosen for. */
  private chosenFor = '';
  /** The two that `answer` is about. */
  private answered = '';
  private readonly questions = new LatestWins<Question>(async (question) => {
    await this.read(question);
    this.busy = this.questions.superseded;
  });

  /** 1 and 2, while they are compared. */
  readonly pair = $derived.by((): readonly [string, string] | null => {
    const [a, b, ...more] = runs.selection.ids;
    return this.opened && a !== undefined && b !== undefined && more.length === 0 ? [a, b] : null;
  });

  /** What is known of 1 and 2; null until it is of both. */
  private readonly known = $derived.by((): readonly [RunDetail, RunDetail] | null => {
    const [one, two] = (this.pair ?? []).map((id) => this.details.find((run) => run.id === id));
    return one && two ? [one, two] : null;
  });

  /** Letters of the variants of 1 and of 2; null until they are known. */
  readonly variantsOfBoth = $derived.by(
    (): readonly [readonly string[], readonly string[]] | null =>
      this.known && [lettersOf(this.known[0]), lettersOf(this.known[1])],
  );

  /** Names of the channels that both have; of variants, those of 1. */
  readonly channelsOfBoth = $derived.by((): readonly string[] => {
    const [one, two] = (this.known ?? []).map(({ columns }) =>
      columns.map(({ name = '' }) => name),
    );
    return (one ?? []).filter((name) => two?.some((other) => alike(name, other)));
  });

  /** Time of 1 up to which neither run was stopped, where they are compared beyond it. */
  readonly beforeStop = $derived(this.known && lastBeforeStop(this.how, this.known));

  /** Takes what the address says. */
  readAddress(): void {
    const address = fromAddress('compare');
    this.opened = address !== null;
    if (address === null) return;
    this.how = howOf(address);
    this.chosenFor = pairText();
    this.channel = fromAddress('channel') ?? this.channel;
  }

  /** Compares the two selected runs, or the selected one with the baseline, which is 1. */
  open(): void {
    const { ids } = runs.selection;
    const base = baseline.id;
    const [first = '', second] = ids;
    if (ids.length === 1 && base !== '' && base !== first) runs.select([base, first]);
    else if (ids.length !== 2) return;
    else if (second === base && base !== '') runs.select([base, first]);
    // A tolerance for one pair says nothing of another.
    if (this.chosenFor !== pairText()) this.how = USUAL;
    this.chosenFor = pairText();
    this.opened = true;
    this.tell();
  }

  close(): void {
    this.opened = false;
    setAddress({ compare: '', channel: '' });
  }

  swap(): void {
    const { pair } = this;
    if (!pair) return;
    runs.select([pair[1], pair[0]]);
    this.change(swapped(this.how));
  }

  change(how: Partial<How>): void {
    this.how = { ...this.how, ...how };
    this.tell();
  }

  /** Compares further channels, besides those that are compared now. */
  add(pattern: string): void {
    const { how, answer } = this;
    if (pattern === '' || how.only.includes(pattern)) return;
    const present = how.exact ? [] : (answer?.channels.map(({ name }) => name) ?? []);
    const only = how.only.length > 0 ? how.only : present;
    this.change({ only: only.includes(pattern) ? only : [...only, pattern] });
  }

  setRule(pattern: string, rule: Rule | null): void {
    const others = Object.entries(this.how.rules).filter(([each]) => each !== pattern);
    const all = rule === null ? others : [...others, [pattern, rule] as const];
    this.change({ rules: Object.fromEntries(all) });
  }

  show(channel: string): void {
    this.channel = channel;
    this.tell();
  }

  /** Asks the server again. Verdicts of another pair are not shown meanwhile. */
  ask(a: string, b: string, how: How): void {
    if (this.answered !== `${a} ${b}`) this.answer = null;
    this.busy = true;
    this.questions.push({ a, b, how });
  }

  private tell(): void {
    if (!this.opened) return;
    setAddress({ compare: JSON.stringify(bodyOf(this.how)), channel: this.channel });
  }

  private async read({ a, b, how }: Question): Promise<void> {
    const current = () => this.pair?.[0] === a && this.pair[1] === b;
    try {
      // Kept also of runs whose comparison is refused; that refusal may come first, and these
      // details once another pair is compared.
      const details = Promise.all([this.detail(a), this.detail(b)]).then((both) => {
        if (current()) this.details = both;
      });
      const [answer] = await Promise.all([compareRuns({ a, b, ...bodyOf(how) }), details]);
      if (!current()) return;
      this.answer = answer;
      this.answered = `${a} ${b}`;
      this.problem = '';
      this.fieldProblems = {};
      if (!answer.channels.some(({ verdict }) => verdict === this.verdict)) this.verdict = '';
      this.chooseChannel(answer);
    } catch (error) {
      if (!current()) return;
      // Verdicts of other runs or another question are none of this one.
      this.answer = null;
      this.fieldProblems = problemsOf(error);
      this.problem = Object.keys(this.fieldProblems).length > 0 ? '' : errorText(error);
    }
  }

  private async detail(id: string): Promise<RunDetail> {
    const known = this.details.find((each) => each.id === id && each.state !== 'recording');
    const run = known ?? (await getRun(id));
    if (!runs.selected.some((each) => each.id === id)) runs.note(run);
    return run;
  }

  /** Shows a channel that can be drawn, if the present one is none. */
  private chooseChannel({ channels }: Comparison): void {
    const drawn = channels.filter(({ at }) => at !== null);
    if (drawn.some(({ name }) => name === this.channel)) return;
    const first = FIRST.find((name) => drawn.some((each) => each.name === name));
    const share = ({ largest, range }: (typeof drawn)[number]) =>
      Math.abs(largest ?? 0) / (range || 1);
    const [worst] = drawn
      .filter(({ verdict }) => VERDICTS[verdict].look === 'bad')
      .sort((a, b) => share(b) - share(a));
    this.channel = worst?.name ?? first ?? drawn[0]?.name ?? '';
  }
}

/** Whether two names are of one channel, whatever the variants. */
function alike(one: string, other: string): boolean {
  const of = (name: string) => name.replace(/^[A-Z]\./, '');
  return of(one) === of(other);
}

function pairText(): string {
  return [...runs.selection.ids].sort().join();
}

/**
 * What is wrong with fields that the panel has, by `offset`, `start`, `tolerance`, `variants.M`,
 * `only.PATTERN`, or the pattern of a rule.
 */
function problemsOf(error: unknown): Record<string, string> {
  const fields = error instanceof ApiError && error.status === 422 ? error.problem.errors : [];
  return Object.fromEntries(
    fields.map((field) => {
      const key = field.loc.replace(/^channels\./, '').replace(/^(tolerance)\..*/, '$1');
      const range = field.range ? ` Allowed: ${field.range}.` : '';
      return [key, `${field.message}.${range}`];
    }),
  );
}

export const comparison = new ComparisonOfTwo();
