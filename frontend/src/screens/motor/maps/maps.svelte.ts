/** What the Force maps tab knows and does. */

import { ApiError } from '../../../app/api/client';
import type { FieldPicture, MapEntry, MapTables } from '../../../app/api/types';
import { errorText } from '../../../app/error-text';
import { JobStore } from '../../../app/jobs/job-store.svelte';
import { LatestWins } from '../../../app/latest-wins';
import { messages } from '../../../app/messages.svelte';
import { fromAddress, load, recordOf, save, setAddress } from '../../../app/storage';
import { app } from '../../../app/store.svelte';
import { numberIn, refusals, type Numbers } from '../quantity-fields';
import { changesFrom, geometryFields, type Design } from './geometry-fields';

const KEPT = 'motor.geometry';
/** Time without another number before the server is asked, ms. */
const PAUSE = 60;
/** A field takes a second to solve: that is asked for when a number stands. */
const PAUSE_FIELD = 400;

/** How well a map is computed. */
export type Accuracy = MapEntry['preset'];
export type View = 'curves' | 'surface' | 'field';

const viewOf = (name: string | null): View =>
  name === 'surface' || name === 'field' ? name : 'curves';

type Shown = MapTables & { preview: boolean };

class Maps {
  readonly job = new JobStore(app.api, 'map');
  geometry = $state.raw<Numbers>(
    load<{ set: Numbers }>(KEPT, { set: {} }, { set: recordOf(0) }).set,
  );
  accuracy = $state<Accuracy>('default');
  shown = $state.raw<Shown | null>(null);
  list = $state.raw<readonly MapEntry[]>([]);
  view = $state<View>(viewOf(fromAddress('view')));
  problems = $state.raw<Record<string, string>>({});
  /** Whether what is shown answers what the form says. */
  fresh = $state(false);
  /** Whether there is nothing to show because the server refused or did not answer. */
  failed = $state(false);
  picture = $state.raw<FieldPicture | null>(null);
  position = $state(-2.1e-3);
  current = $state(10);
  /** Whether the field that is drawn is older than what is asked for. */
  solving = $state(false);
  fieldProblem = $state('');
  private defaults: Numbers = {};
  private last: string | null = null;
  /** The job whose map was shown; of jobs that are only found again none is. */
  private handled: string | null = null;
  private readonly timers = new Map<string, ReturnType<typeof setTimeout>>();
  private readonly previews = new LatestWins<Numbers>((geometry) => this.runPreview(geometry));
  private readonly fields = new LatestWins<object>((body) => this.runField(body));

  /** Name of the stored map that is shown, or nothing while the preview is. */
  readonly opened = $derived(this.shown && !this.shown.preview ? this.shown.name : '');

  /** Loads what is stored; shows the map of the address, else the preview. */
  async start(): Promise<void> {
    this.failed = false;
    await app.try(async () => {
      const [first] = await Promise.all([app.api.previewMap({}), this.refresh()]);
      this.defaults = first.geometry;
      const name = fromAddress('map');
      if (name && this.list.some((entry) => entry.name === name)) await this.open(name);
      else if (Object.keys(this.geometry).length > 0) this.preview();
      else this.show({ ...first, preview: true });
    });
    this.failed = Object.keys(this.defaults).length === 0;
    await app.try(() => this.job.resume());
    const { report } = this.job;
    this.handled = report?.state === 'done' ? report.id : '';
  }

  /** Shows the map of a job that is done, once. */
  follow(): void {
    const { report } = this.job;
    if (report?.state !== 'done' || !report.result) return;
    if (this.handled === null || report.id === this.handled) return;
    this.handled = report.id;
    const { name } = report.result;
    void app.try(() => this.refresh()).then(() => this.open(name));
  }

  value(path: string): number | null {
    return this.geometry[path] ?? this.defaults[path] ?? numberIn(this.shown?.geometry, path);
  }

  take(path: string, value: number): void {
    this.last = path;
    this.change({ ...this.geometry, [path]: value });
  }

  reset(path: string): void {
    this.change(Object.fromEntries(Object.entries(this.geometry).filter(([key]) => key !== path)));
  }

  design({ geometry }: Design): void {
    this.change(geometry);
  }

  async compute(): Promise<void> {
    try {
      const body = { preset: this.accuracy, geometry: this.geometry };
      await this.job.once(async () => {
        const answer = await app.api.computeMap(body);
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
      this.geometry = changesFrom(tables.geometry, this.defaults);
      save(KEPT, { set: this.geometry });
      setAddress({ map: name });
      this.show({ ...tables, preview: false });
    });
  }

  async remove(name: string): Promise<void> {
    await app.try(async () => {
      await app.api.dropMap(name);
      await this.refresh();
      if (this.opened === name) this.preview();
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
    this.current = Math.max(0, Math.min(current, this.value('i') ?? current));
    this.draw();
  }

  /** Asks for the field at the position and current of the form, where it is looked at. */
  draw(): void {
    if (this.view !== 'field') return;
    this.solving = true;
    const { position, geometry } = this;
    const current = Math.min(this.current, this.value('i') ?? this.current);
    this.later('field', PAUSE_FIELD, () =>
      this.fields.push({ geometry, position, current, columns: 192, lines: 24 }),
    );
  }

  private change(geometry: Numbers): void {
    this.geometry = geometry;
    save(KEPT, { set: geometry });
    this.preview();
  }

  private preview(): void {
    setAddress({ map: '' });
    this.fresh = false;
    this.later('preview', PAUSE, () => this.previews.push(this.geometry));
  }

  private later(what: string, pause: number, action: () => void): void {
    clearTimeout(this.timers.get(what));
    this.timers.set(what, setTimeout(action, pause));
  }

  private async refresh(): Promise<void> {
    this.list = await app.api.maps();
  }

  private show(map: Shown): void {
    this.shown = map;
    this.problems = {};
    this.fresh = !this.previews.superseded;
    this.draw();
  }

  private async runPreview(geometry: Numbers): Promise<void> {
    try {
      this.show({ ...(await app.api.previewMap(geometry)), preview: true });
    } catch (error) {
      this.refuse(error);
    }
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

  private refuse(error: unknown): void {
    if (!(error instanceof ApiError) || error.problem.errors.length === 0) {
      messages.error(errorText(error));
      return;
    }
    const errors = error.problem.errors.map((one) => ({
      ...one,
      loc: one.loc.replace(/^(geometry|map)\.?/, ''),
    }));
    this.problems = refusals(errors, geometryFields(), this.last);
  }
}

export const maps = new Maps();
