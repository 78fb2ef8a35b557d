/** The request of a study as a person edits it: values by dotted path, over the server's defaults. */

import { ApiError, UNREACHABLE } from '../app/api/client';
import { at, equal, withChanges, without } from '../app/api/scenario-paths';
import type {
  Changes,
  FieldEntry,
  JobKind,
  ProblemField,
  Scenario,
  StudyKind,
  Value,
} from '../app/api/types';
import { errorText } from '../app/error-text';
import {
  type Entries,
  entryOf,
  type Field,
  fieldOf,
  refusal,
  served,
} from '../app/fields/fields.svelte';
import { type ScenarioSource, inlineScenarioOf, wholeOf } from '../app/jobs/job-request';
import { JobStore } from '../app/jobs/job-store.svelte';
import { load, recordOf, save } from '../app/storage';
import { app } from '../app/store.svelte';
import { prettyUnit } from '../ui/units';
import { LatestWins } from '../app/latest-wins';

type Request = Readonly<Record<string, unknown>>;

/** Puts dotted paths into tables: `{'x.mass': 5}` becomes `{x: {mass: 5}}`. */
export function nested(values: Readonly<Record<string, unknown>>): Record<string, unknown> {
  const root: Record<string, unknown> = {};
  for (const [path, value] of Object.entries(values)) {
    const keys = path.split('.');
    let table = root;
    for (const key of keys.slice(0, -1)) {
      table = (table[key] ??= {}) as Record<string, unknown>;
    }
    table[keys[keys.length - 1] as string] = value;
  }
  return root;
}

/** Whether a kept value can be one of a field: of the type of its default, or a number where it has a unit. */
function fits(value: Value, entry: FieldEntry | undefined): boolean {
  if (!entry || value === null) return entry !== undefined;
  const number = entry.unit !== '' || entry.whole || entry.bounds;
  const sample = (entry.default ?? entry.example ?? (number ? 0 : value)) as Value;
  if (typeof sample !== typeof value || Array.isArray(sample) !== Array.isArray(value))
    return false;
  if (!Array.isArray(value)) return true;
  return value.every((item) => typeof item === (entry.unit === '' ? 'string' : 'number'));
}

export class StudyForm {
  /** What a person has entered. */
  entered = $state.raw<Changes>({});
  /** Why fields are refused; at '' what belongs to no single one. */
  problems = $state.raw<Readonly<Record<string, string>>>({});
  /** Paths whose problems stand at their fields, with how many rows show each. */
  readonly placed = $state<Record<string, number>>({});
  /** The field that was changed last, to which what is refused of its table belongs. */
  protected last = '';
  readonly entries = $derived.by((): Entries => served.requests[this.kind] ?? {});
  /** Fields without fields below them, of the study itself. */
  private readonly leaves = $derived.by(() => {
    const paths = Object.keys(this.entries).filter(
      (path) => !path.includes('*') && !/^(scenario|set)(\.|$)/.test(path),
    );
    return paths.filter((path) => !paths.some((other) => other.startsWith(`${path}.`)));
  });

  /** How much of it a reset gives up. */
  readonly changed = $derived.by(() => {
    const { entered, initial } = this;
    return Object.keys({ ...initial, ...entered }).filter(
      (path) => !this.lasts?.(path) && !equal(entered[path], initial[path]),
    ).length;
  });

  /** What is refused and shown at no field, with the names of the fields. */
  readonly unplaced = $derived.by(() =>
    Object.entries(this.problems).flatMap(([path, text]) =>
      path !== '' && this.placed[path] ? [] : [path === '' ? text : `${this.label(path)}: ${text}`],
    ),
  );

  /** @param initial what the form begins with in place of the server's defaults */
  constructor(
    readonly kind: StudyKind,
    private readonly initial: Changes = {},
  ) {
    const kept = load<Changes>(this.key, initial, recordOf(null));
    const known = Object.entries(kept).filter(([path, value]) => fits(value, this.entry(path)));
    this.entered = Object.fromEntries(known);
  }

  private get key(): string {
    return `study.${this.kind}`;
  }

  /** The path in the request of a path that only the form has. */
  alias(path: string): string {
    return path;
  }

  entry(path: string): FieldEntry | undefined {
    return entryOf(this.alias(path), this.entries);
  }

  label(path: string): string {
    return this.field(path).label;
  }

  /** How a field is called and shown. */
  field(path: string): Field {
    const entry = this.entry(path);
    return entry
      ? { ...entry, unit: prettyUnit(entry.unit) }
      : fieldOf(this.alias(path), this.entries);
  }

  /** What holds: what was entered, else the default. */
  value(path: string): Value {
    return this.entered[path] ?? (path in this.entered ? null : this.usual(path));
  }

  /** What a field has where nothing was entered. */
  protected usual(path: string): Value {
    return (this.entry(path)?.default as Value | undefined) ?? null;
  }

  number(path: string): number | null {
    const value = this.value(path);
    return typeof value === 'number' ? value : null;
  }

  text(path: string): string {
    const value = this.value(path);
    return typeof value === 'string' ? value : '';
  }

  change(changes: Changes): void {
    this.last = Object.keys(changes)[0] ?? '';
    this.put({ ...this.entered, ...changes });
  }

  /** Gives up what was entered in fields, or in all. */
  reset(paths?: readonly string[]): void {
    if (paths) {
      this.put(without(this.entered, paths));
      return;
    }
    const lasting = Object.entries(this.entered).filter(([path]) => this.lasts?.(path));
    this.put({ ...this.initial, ...Object.fromEntries(lasting) });
  }

  /** Whether a field stays as it is when the form is reset. */
  protected lasts?(path: string): boolean;

  /** Takes all that is entered. */
  put(entered: Changes): void {
    this.entered = entered;
    this.problems = {};
    save(this.key, entered);
  }

  /** The request's own tables. */
  body(): Record<string, unknown> {
    return nested(this.entered);
  }

  /** Puts a request into the form. */
  restore(request: Request): void {
    const entered = this.leaves.flatMap((path) => {
      const value = at(request, path);
      return value === undefined || equal(value, this.usual(path)) ? [] : [[path, value] as const];
    });
    this.put(Object.fromEntries(entered));
  }

  /** Names of the settings in which a request differs from another. */
  differing(request: Request | undefined, other: object): readonly string[] {
    if (!request) return [];
    const of = (body: object, path: string) => {
      const value = at(body, path);
      return value === undefined ? this.usual(path) : value;
    };
    const tables = this.leaves
      .filter((path) => !equal(of(request, path), of(other, path)))
      .map((path) => path.split('.')[0] as string);
    return tables
      .filter((table, k) => tables.indexOf(table) === k)
      .map((table) => this.label(table));
  }

  /** Says what the server has against the request, at its fields. */
  refuse(error: unknown): void {
    const refused = error instanceof ApiError && error.problem.status !== UNREACHABLE;
    const errors = refused ? error.problem.errors : [];
    if (errors.length === 0) {
      this.problems = { '': errorText(error) };
      return;
    }
    const problems: Record<string, string> = {};
    for (const problem of errors) {
      const place = this.placeOf(problem);
      const text = this.refusal(problem);
      if (problems[place]?.includes(text)) continue;
      problems[place] = place in problems ? `${problems[place]} ${text}` : text;
    }
    this.problems = problems;
  }

  /** Counts rows in which fields are shown. */
  place(paths: readonly string[], rows: 1 | -1): void {
    for (const path of paths) this.placed[path] = (this.placed[path] ?? 0) + rows;
  }

  /** What is refused of a table as a whole belongs to the field that was changed last. */
  protected placeOf({ loc }: ProblemField): string {
    if (this.placed[loc]) return loc;
    const list = loc.replace(/\.\d+$/, '');
    if (this.placed[list]) return list;
    if (this.last !== '' && this.last.startsWith(loc)) return this.last;
    return this.entry(loc) ? loc : '';
  }

  protected refusal(problem: ProblemField): string {
    return refusal(problem, this.entries);
  }
}

/** A study of a scenario: a shipped one, or that of the Lab with what is staged. */
export class ScenarioForm extends StudyForm {
  /** Name of a shipped scenario; empty: what the Lab shows. */
  source = $state('');
  private named = $state.raw<Scenario | null>(null);

  readonly question = $derived.by((): ScenarioSource | null => {
    if (this.source !== '') return this.named ? { scenario: this.named, set: {} } : null;
    const scenario = app.session.info?.scenario;
    return scenario ? { scenario, set: this.staged } : null;
  });

  /** The scenario with its changes, for what the page shows of it. */
  readonly scenario = $derived.by((): Scenario | null => {
    if (this.source === '') return app.scenario;
    return this.question && withChanges(this.question.scenario, this.question.set);
  });

  /**
   * @param controllers fields that name a controller of the scenario, with the one that they name
   *   unless another is chosen: 0, or 1 where there are two
   */
  constructor(
    kind: StudyKind,
    initial: Changes = {},
    private readonly controllers: Readonly<Record<string, number>> = {},
  ) {
    super(kind, initial);
    this.source = load(`${kind}.source`, '');
  }

  protected get staged(): Changes {
    return app.mode === 'whatif' ? app.draft : {};
  }

  readonly variants = $derived.by(() => Object.keys(this.question?.scenario.variants ?? {}));

  /** Controllers as choices of a field. */
  readonly choices = $derived.by(() =>
    this.variants.map((value) => ({ value, name: `controller ${value}` })),
  );

  override value(path: string): Value {
    const value = super.value(path);
    const known = !(path in this.controllers) || this.variants.includes(String(value));
    return known ? value : this.usual(path);
  }

  protected override usual(path: string): Value {
    const number = this.controllers[path];
    if (number === undefined) return super.usual(path);
    return this.variants[number] ?? this.variants[0] ?? '';
  }

  /** A job of this form, whose request comes back into it. */
  jobOf<K extends JobKind>(kind: K): JobStore<K> {
    // What requests of another kind do not have stays as it is.
    const kept = () => (kind === this.kind ? {} : this.body());
    return new JobStore(app.api, kind, (request) => this.restore({ ...kept(), ...request }));
  }

  /** Reads the named scenario, and finds the jobs again. */
  async open(...jobs: { resume: () => Promise<void> }[]): Promise<void> {
    await app.try(async () => {
      await this.choose(this.source);
      await Promise.all(jobs.map((job) => job.resume()));
    });
  }

  async choose(source: string): Promise<void> {
    this.source = source;
    save(`${this.kind}.source`, source);
    await app.try(async () => {
      const scenario = source === '' ? null : await app.api.scenario(source);
      if (this.source === source) this.named = scenario;
    });
  }

  /** Starts a job; what is refused stands at the fields. */
  async start(begin: (question: ScenarioSource) => Promise<void>): Promise<void> {
    this.problems = {};
    if (!this.question) return;
    try {
      await begin(this.question);
    } catch (error) {
      this.refuse(error);
    }
  }

  /** Whether a request is of another scenario than the one that is shown now. */
  otherThan(request: Request | undefined): boolean {
    if (!request || !this.question) return false;
    const then = inlineScenarioOf(request);
    if (!then) return request['scenario'] !== this.source;
    const { resolved } = app.catalogue;
    return !equal(wholeOf(then, resolved), wholeOf(this.question, resolved));
  }
}

/** Time without another number before the server is asked, ms. */
const PAUSE = 60;

export abstract class InstantForm<A> extends StudyForm {
  answer = $state.raw<A | null>(null);
  /** Whether the answer is of what the form says. */
  fresh = $state(false);
  /** Whether there is nothing to show because the server refused or did not answer. */
  readonly failed = $derived.by(
    () => this.answer === null && Object.keys(this.problems).length > 0,
  );
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly queue = new LatestWins<null>(() => this.run());

  constructor(kind: StudyKind, initial: Changes = {}) {
    super(kind, initial);
  }

  /** Answers what the form says; null where a newer question waits. */
  protected abstract request(): Promise<A | null>;

  protected get superseded(): boolean {
    return this.queue.superseded;
  }

  override put(entered: Changes): void {
    super.put(entered);
    this.ask();
  }

  /** Takes what is entered without asking. */
  protected keep(entered: Changes): void {
    super.put(entered);
  }

  ask(): void {
    this.fresh = false;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.queue.push(null), PAUSE);
  }

  /** Shows an answer that was not asked for by the form. */
  protected show(answer: A): void {
    this.answer = answer;
    this.problems = {};
    this.fresh = !this.superseded;
  }

  private async run(): Promise<void> {
    try {
      const answer = await this.request();
      if (answer !== null) this.show(answer);
    } catch (error) {
      this.refuse(error);
    }
  }
}
