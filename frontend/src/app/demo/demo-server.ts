/** What stands in for the server in a demo: its answers from files, what-ifs for the page's kernel. */

import { type Lanes, packLanes } from '../../kernel/lanes';
import { network } from '../api/client';
import { equal, withChanges } from '../api/scenario-paths';
import type { Channel } from '../../plot/source';
import type { Changes, Scenario, SessionInfo, TrajectoryEntry, Value } from '../api/types';
import { app } from '../store.svelte';
import { recall } from '../session/kept-sessions';
import { Beyond, changedLanes, type LaneCode } from '../whatif/changed-lanes';
import { Refused } from '../whatif/refused-changes';
import { NEEDS_SERVER } from './demo-mode';
import type { MotionCode } from './motion-code';
import type { MotionRanges } from './motion-limits';
import type { Moved } from './moved-lanes';
import { readPacked } from './packed-inputs';
import { json, problem, refusal } from './responses';
import type { SpectrumRequest } from './spectrum';
import type { WhyData, WhyRequest } from './why';

/** The scenario of a first visit. */
const FIRST = 'circle';
const PATHS = '/trajectories';

interface Answers {
  plants: Record<string, Value>;
  channels: Channel[];
  why: WhyData;
  bounds: MotionRanges;
  [path: string]: unknown;
}

interface LanesRequest {
  scenario: Scenario;
  set?: Changes;
  inputs?: string;
  tables?: string;
}

/** Says which file of the demo cannot be read. */
function unread(url: string): Error {
  return new Error(
    `This demo is not whole: ${url.split('/').at(-1)} cannot be read. Load it anew.`,
  );
}

/** Reads a file of the demo; texts and numbers in it are compressed. */
async function unzipped<T>(url: string, read: (file: Response) => Promise<T>): Promise<T> {
  try {
    const response = await fetch(url);
    if (!response.ok || !response.body) throw new Error(response.statusText);
    return await read(new Response(response.body.pipeThrough(new DecompressionStream('gzip'))));
  } catch {
    throw unread(url);
  }
}

export class DemoServer {
  private readonly lanes = new Map<string, Promise<Lanes>>();
  /** The latest motion that is no shipped one. */
  private motion: (Moved & { of: Lanes; trajectory: Scenario['trajectory'] }) | null = null;
  private motionCode: Promise<MotionCode> | null = null;

  private constructor(
    private readonly folder: string,
    readonly answers: Answers,
    private readonly code: LaneCode,
  ) {}

  static async open(folder: string): Promise<DemoServer> {
    const [answers, code] = await Promise.all([
      unzipped(`${folder}answers.bin`, (file) => file.json() as Promise<Answers>),
      import('../../../lanes.js').catch(() => Promise.reject(unread('lanes.js'))),
    ]);
    return new DemoServer(folder, answers, code);
  }

  /** Answers a request below the API's root. */
  async answer(method: string, path: string, body: string): Promise<Response> {
    if (method === 'GET' && path !== PATHS && path in this.answers) return json(this.answers[path]);
    if (path === '/sessions' && method === 'POST') return this.create(body);
    const [, id] = /^\/sessions\/([^/]+)$/.exec(path) ?? [];
    if (id !== undefined && method === 'DELETE') return new Response(null, { status: 204 });
    if (id !== undefined && method === 'GET') {
      const kept = recall(id);
      const scenario = kept?.scenario ?? (this.shipped(FIRST) as Scenario);
      return json(sessionOf(id, scenario, kept?.base ?? scenario));
    }
    if (path === '/whatif/lanes') return this.whatIf(JSON.parse(body) as LanesRequest);
    if (path === '/why') return this.why(JSON.parse(body) as WhyRequest);
    if (path === '/scenarios/parse') return this.motor(body);
    if (path === '/spectrum' || path === '/views/ballbar') return view(path, body);
    if (path.startsWith(PATHS)) return this.paths(method, path, body);
    return problem(501, NEEDS_SERVER);
  }

  /** Answers what the screen of paths asks. */
  private async paths(...request: [method: string, path: string, body: string]): Promise<Response> {
    const [{ answerOfPaths }, code] = await Promise.all([import('./path-routes'), this.motions()]);
    const shipped = this.answers[PATHS] as TrajectoryEntry[];
    return answerOfPaths(code, request, shipped, this.parts, this.answers.bounds);
  }

  /** Motion profiles and curves. */
  private motions(): Promise<MotionCode> {
    const url = `${this.folder}motions.js`;
    this.motionCode ??= import(/* @vite-ignore */ url).catch(() => Promise.reject(unread(url)));
    return this.motionCode as Promise<MotionCode>;
  }

  private shipped(name: string): Scenario | undefined {
    return this.answers[`/scenarios/${name}`] as Scenario | undefined;
  }

  private create(body: string): Response {
    const { scenario = FIRST, set = {} } = JSON.parse(body) as {
      scenario?: Scenario | string;
      set?: Changes;
    };
    const whole = typeof scenario === 'string' ? this.shipped(scenario) : scenario;
    if (!whole) return problem(404, `This demo has no scenario ${String(scenario)}.`);
    const changed = withChanges(whole, set, this.parts);
    return json(sessionOf(`demo-${Date.now().toString(36)}`, changed, changed));
  }

  private get parts(): Record<string, Value> {
    const entries = Object.entries(this.answers.plants);
    return Object.fromEntries(entries.map(([name, plant]) => [`plant=${name}`, plant]));
  }

  /** Answers which motor a name stands for: the page asks in TOML. */
  private motor(toml: string): Response {
    const [, name = ''] = /^base = "circle"\nplant = "([^"]+)"\n$/.exec(toml) ?? [];
    const plant = this.answers.plants[name];
    return plant ? json({ ...this.shipped(FIRST), plant }) : problem(501, NEEDS_SERVER);
  }

  private async whatIf(request: LanesRequest): Promise<Response> {
    const { scenario, set = {}, inputs, tables } = request;
    try {
      const lanes = await this.lanesWith(withChanges(scenario, set, this.parts));
      const answer = {
        ...lanes,
        inputs: inputs === lanes.keys.inputs ? null : lanes.inputs,
        tables: tables === lanes.keys.tables ? null : lanes.tables,
      };
      return new Response(packLanes(answer));
    } catch (error) {
      return refusal(error);
    }
  }

  private async why(request: WhyRequest): Promise<Response> {
    const { whyDocument } = await import('./why-run');
    try {
      const whole = withChanges(request.scenario, request.set ?? {}, this.parts);
      const lanes = await this.lanesWith(whole);
      const motions = await this.motions();
      return json(await whyDocument(this.answers.why, request, [this.code, lanes, whole], motions));
    } catch (error) {
      return refusal(error);
    }
  }

  /**
   * The lanes of a changed scenario, with inputs and tables.
   *
   * @throws Refused, Beyond
   */
  private async lanesWith(whole: Scenario): Promise<Lanes> {
    const shipped = this.shipped(whole.name);
    if (!shipped) throw new Beyond('the demo has shipped scenarios alone');
    const lanes = await this.lanesOf(whole.name);
    const moved = await this.moved(lanes, shipped, whole);
    const { trajectory } = moved ? whole : shipped;
    return changedLanes(this.code, moved ?? lanes, { ...shipped, trajectory }, whole);
  }

  /** The lanes of another motion than the shipped one; null where it is the shipped one. */
  private async moved(
    lanes: Lanes,
    shipped: Scenario,
    { trajectory, plant, schedule, window }: Scenario,
  ): Promise<Lanes | null> {
    if (equal(shipped.trajectory, trajectory)) return null;
    const { REFERENCE_ROWS, withMotion } = await import('./moved-lanes');
    const { checkRanges, infeasible } = await import('./motion-limits');
    const references = lanes.rows.every(([row]) => REFERENCE_ROWS.some((name) => name === row));
    // What depends on the times of the shipped motion.
    if (!references || schedule.length > 0 || window) return null;
    checkRanges(trajectory, this.answers.bounds);
    const code = await this.motions();
    const known = this.motion;
    const motion =
      known && known.of === lanes && equal(known.trajectory, trajectory)
        ? known
        : { of: lanes, trajectory, ...withMotion(code, lanes, trajectory, this.startRow) };
    this.motion = motion;
    const beyond = infeasible(code, motion.reference, plant);
    if (beyond.length > 0) throw new Refused(beyond);
    return motion.lanes;
  }

  private get startRow(): number {
    return this.code.STATES.indexOf('plant.p');
  }

  private lanesOf(name: string): Promise<Lanes> {
    const lanes =
      this.lanes.get(name) ??
      unzipped(`${this.folder}${name}.bin`, async (file) => readPacked(await file.arrayBuffer()));
    this.lanes.set(name, lanes);
    lanes.catch(() => this.lanes.delete(name));
    return lanes;
  }
}

/** Computed by what is loaded once it is asked for. */
async function view(path: '/spectrum' | '/views/ballbar', body: string): Promise<Response> {
  const { ballbar, spectrumDocument } = await import('./demo-views');
  try {
    if (path === '/spectrum') return json(spectrumDocument(JSON.parse(body) as SpectrumRequest));
    return json(await ballbar(JSON.parse(body) as LanesRequest));
  } catch (error) {
    return problem(422, error instanceof Error ? error.message : String(error));
  }
}

/** A session that never moves; without a stream. */
function sessionOf(id: string, scenario: Scenario, base: Scenario): SessionInfo {
  return {
    id,
    revision: 0,
    timeline: 0,
    state: 'paused',
    tick: 0,
    time: 0,
    speed: 1,
    stream: '',
    run: null,
    recorded_from: 0,
    unrecorded: '',
    watchers: 0,
    people: [],
    events: [],
    ends: null,
    diverged: {},
    drive: '',
    changes: [],
    base,
    scenario,
  };
}

/** Puts the files of a demo in place of the server, and keeps them for a page without a network. */
export function startDemo(folder: string): void {
  const server = DemoServer.open(folder);
  network.request = async (method, path, init) => {
    try {
      return await (
        await server
      ).answer(method, path, typeof init.body === 'string' ? init.body : '');
    } catch (error) {
      return problem(500, error instanceof Error ? error.message : String(error));
    }
  };
  server.then(
    ({ answers }) => (app.session.channels = answers.channels),
    () => undefined, // each request says it
  );
  if ('serviceWorker' in navigator) {
    // A host without https has none: the demo then needs its network.
    navigator.serviceWorker.register('sw.js').catch(() => undefined);
  }
}
