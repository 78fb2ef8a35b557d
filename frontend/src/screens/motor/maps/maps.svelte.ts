/** What the Force maps tab knows and does. */

import type { Changes, FieldPicture, MapEntry, MapTables, Value } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { JobStore } from '../../../app/jobs/job-store.svelte';
import { LatestWins } from '../../../app/latest-wins';
import { fromAddress, setAddress } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { SavedDocuments } from '../../../parts/saved/saved-documents.svelte';
import { InstantForm } from '../../../study/study-form.svelte';
import type { Numbers } from '../quantity-fields';

/** A field takes a second to solve: that is asked for when a number stands, ms. */
const PAUSE_FIELD = 400;

/** How well a map is computed. */
export type Accuracy = MapEntry['preset'];
export type View = 'curves' | 'surface' | 'field';

const viewOf = (name: string | null): View =>
  name === 'surface' || name === 'field' ? name : 'curves';

type Shown = MapTables & { preview: boolean };

class Maps extends InstantForm<Shown> {
  readonly job = new JobStore(app.api, 'map');
  readonly library = new SavedDocuments<MapEntry>({
    noun: 'map',
    list: app.api.maps,
    drop: app.api.dropMap,
    changed: (name) => {
      if (this.opened === name) this.ask();
    },
  });
  view = $state<View>(viewOf(fromAddress('view')));
  picture = $state.raw<FieldPicture | null>(null);
  position = $state(-2.1e-3);
  current = $state(10);
  /** Whether the field that is drawn is older than what is asked for. */
  solving = $state(false);
  fieldProblem = $state('');
  /** The job whose map was shown; of jobs that were done when the page was loaded none is. */
  private handled: string | null = null;
  private solver: ReturnType<typeof setTimeout> | undefined;
  private readonly fields = new LatestWins<object>((body) => this.runField(body));

  /** Name of the stored map that is shown, or nothing while the preview is. */
  readonly opened = $derived(this.answer && !this.answer.preview ? this.answer.name : '');
  /** What differs from the paper's motor, by the name in its geometry. */
  readonly geometry = $derived.by((): Numbers => (this.body()['geometry'] ?? {}) as Numbers);

  /** Loads what is stored; shows the map of the address, else the preview. */
  async start(): Promise<void> {
    await this.library.refresh();
    const name = fromAddress('map');
    if (name && this.library.has(name)) await this.open(name);
    else this.ask();
    await app.try(() => this.job.resume());
    const { report } = this.job;
    this.handled ??= report?.state === 'done' ? report.id : '';
  }

  /** Shows the map of a job that is done, once. */
  follow(): void {
    const { report } = this.job;
    if (report?.state !== 'done' || !report.result) return;
    if (this.handled === null || report.id === this.handled) return;
    this.handled = report.id;
    const { name } = report.result;
    void this.library.refresh().then(() => this.open(name));
  }

  protected override lasts(path: string): boolean {
    return path === 'preset';
  }

  /** Takes the geometry of a design, in place of what was entered. */
  design(geometry: Numbers): void {
    this.put(this.withGeometry(geometry));
  }

  async compute(): Promise<void> {
    try {
      await this.job.once(async () => {
        const answer = await app.api.computeMap({ geometry: {}, ...this.body() });
        this.problems = {};
        if ('content_hash' in answer) await this.open(answer.name);
        else this.job.follow(answer);
      });
    } catch (error) {
      this.refuse(error);
    }
  }

  async open(name: string): Promise<void> {
    await app.try(async () => {
      const tables = await app.api.map(name);
      this.keep(this.withGeometry(tables.geometry));
      setAddress({ map: name });
      this.show({ ...tables, preview: false });
    });
  }

  look(view: View): void {
    this.view = view;
    setAddress({ view });
    this.draw();
  }

  /** Takes where and at which current the field is looked at. */
  at(position: number, current: number): void {
    this.position = position;
    this.current = Math.max(0, Math.min(current, this.number('geometry.i') ?? current));
    this.draw();
  }

  /** Asks for the field at the position and current of the form, where it is looked at. */
  draw(): void {
    if (this.view !== 'field') return;
    this.solving = true;
    const { position, geometry } = this;
    const current = Math.min(this.current, this.number('geometry.i') ?? this.current);
    clearTimeout(this.solver);
    this.solver = setTimeout(
      () => this.fields.push({ geometry, position, current, columns: 192, lines: 24 }),
      PAUSE_FIELD,
    );
  }

  override ask(): void {
    setAddress({ map: '' });
    super.ask();
  }

  protected override async request(): Promise<Shown> {
    const known = this.known();
    if (known) return { ...(await app.api.map(known.name)), preview: false };
    return { ...(await app.api.previewMap(this.geometry)), preview: true };
  }

  /** The computed map of the geometry of the form; none where a preview is what is wanted. */
  private known(): MapEntry | undefined {
    const accuracy = this.value('preset');
    if (accuracy === 'preview') return undefined;
    const same = (this.library.entries ?? []).filter(
      ({ preset, geometry }) =>
        preset !== 'preview' &&
        Object.entries(geometry).every(
          ([name, value]) => (this.geometry[name] ?? this.usual(`geometry.${name}`)) === value,
        ),
    );
    return same.find(({ preset }) => preset === accuracy) ?? same[0];
  }

  protected override show(map: Shown): void {
    super.show(map);
    this.draw();
  }

  private withGeometry(geometry: Readonly<Record<string, Value>>): Changes {
    const differing = Object.entries(geometry)
      .map(([name, value]) => [`geometry.${name}`, value] as const)
      .filter(([path, value]) => this.usual(path) !== value);
    return { preset: this.value('preset'), ...Object.fromEntries(differing) };
  }

  private async runField(body: object): Promise<void> {
    try {
      this.picture = await app.api.mapField(body);
      this.fieldProblem = '';
    } catch (error) {
      this.fieldProblem = errorText(error);
    } finally {
      this.solving = this.fields.superseded;
    }
  }
}

export const maps = new Maps('map');
