/** REST calls. Every failure is an ApiError that carries the server's problem document. */

import { pretty } from '../../ui/units';
import type {
  Changes,
  FieldEntry,
  DesignDocument,
  FieldPicture,
  Health,
  IdentificationPlan,
  JobKind,
  JobSummary,
  KeptTrajectory,
  LoopAccuracy,
  LoopResponse,
  Loops,
  MapEntry,
  MapFit,
  MapTables,
  PlatformDocument,
  Metrics,
  PaperDocument,
  Parts,
  Problem,
  ReportOf,
  Scenario,
  ScenarioEntry,
  ScenarioFields,
  SessionInfo,
  SharingDocument,
  Slowed,
  Trajectory,
  TrajectoryEntry,
  Axis,
} from './types';

const ROOT = '/api/v1';

/** No answer at all: the server is down or the network is. */
export const UNREACHABLE = 0;

export class ApiError extends Error {
  /** @param retryAfter ms after which the server wants to be asked again; null where it names none */
  constructor(
    readonly problem: Problem,
    readonly retryAfter: number | null = null,
  ) {
    super(pretty(problem.detail || problem.title));
  }

  get status(): number {
    return this.problem.status;
  }

  /** Whether the same request may well succeed later: the server is busy, restarting or out of reach. */
  get transient(): boolean {
    return [UNREACHABLE, 429, 502, 503, 504].includes(this.status);
  }
}

export interface ScenarioRequest {
  scenario?: string | Scenario;
  set?: Changes;
}

export interface TrajectoryRequest extends ScenarioRequest {
  trajectory: Trajectory;
  points?: number;
}

export interface LoopRequest extends ScenarioRequest {
  variant: string;
  axis: Axis;
}

export class Api {
  /** Asks for the token when the server wants one; resolves once a token was accepted. */
  onUnauthorized: (() => Promise<void>) | null = null;

  health = () => this.json<Health>('GET', '/health');
  scenarios = () => this.json<ScenarioEntry[]>('GET', '/scenarios');
  scenario = (name: string) => this.json<Scenario>('GET', `/scenarios/${name}`);
  fields = () => this.json<ScenarioFields>('GET', '/fields');
  requestFields = (kind: JobKind) =>
    this.json<Record<string, FieldEntry>>('GET', `/fields/${kind}`);
  parts = () => this.json<Parts>('GET', '/parts');
  paper = () => this.json<PaperDocument>('GET', '/paper');
  parse = (toml: string) => this.json<Scenario>('POST', '/scenarios/parse', toml);
  create = (body: ScenarioRequest) => this.json<SessionInfo>('POST', '/sessions', body);
  session = (id: string) => this.json<SessionInfo>('GET', `/sessions/${id}`);
  remove = (id: string) => this.send('DELETE', `/sessions/${id}`);
  metrics = (id: string) => this.json<Metrics>('GET', `/sessions/${id}/metrics`);

  command(id: string, name: 'pause' | 'reset' | 'stop' | 'undo'): Promise<SessionInfo>;
  command(id: string, name: 'play', body: { speed: number }): Promise<SessionInfo>;
  command(id: string, name: 'step', body: { ticks: number }): Promise<SessionInfo>;
  command(id: string, name: string, body: object = {}): Promise<SessionInfo> {
    return this.json('POST', `/sessions/${id}/${name}`, body);
  }

  push = (id: string, push: { axis: Axis; force: number; duration: number }) =>
    this.json<{ tick: number }>('POST', `/sessions/${id}/push`, push);
  patch = (id: string, set: Changes) =>
    this.json<{ tick: number }>('PATCH', `/sessions/${id}/parameters`, { set });

  async whatif(
    body: ScenarioRequest & { columns: string[]; points: number; exact: boolean },
    signal: AbortSignal,
  ) {
    const response = await this.send('POST', '/whatif', body, signal);
    return whole(response.arrayBuffer(), signal);
  }

  trajectories = () => this.json<TrajectoryEntry[]>('GET', '/trajectories');
  trajectory = (name: string) => this.json<KeptTrajectory>('GET', `/trajectories/${name}`);
  keepTrajectory = (name: string, table: Trajectory) =>
    this.json<KeptTrajectory>('PUT', `/trajectories/${name}`, table);
  dropTrajectory = (name: string) => this.send('DELETE', `/trajectories/${name}`);
  slow = (body: TrajectoryRequest) => this.json<Slowed>('POST', '/trajectories/slow', body);

  async check(body: TrajectoryRequest) {
    return whole((await this.send('POST', '/trajectories/check', body)).arrayBuffer());
  }

  platform = (body: object) => this.json<PlatformDocument>('POST', '/design/platform', body);
  design = (body: object) => this.json<DesignDocument>('POST', '/design', body);

  maps = () => this.json<MapEntry[]>('GET', '/maps');
  map = (name: string) => this.json<MapTables>('GET', `/maps/${name}?positions=97&currents=11`);
  dropMap = (name: string) => this.send('DELETE', `/maps/${name}`);
  /** A job, or at once the entry of a map that was computed before. */
  computeMap = (body: object) => this.json<MapEntry | ReportOf<'map'>>('POST', '/maps', body);
  previewMap = (geometry: object) =>
    this.json<MapTables>('POST', '/maps/preview?positions=97&currents=11', geometry);
  fitMap = (name: string) => this.json<MapFit>('GET', `/maps/${name}/fit`);
  shareForce = (body: object) => this.json<SharingDocument>('POST', '/design/sharing', body);
  mapField = (body: object) => this.json<FieldPicture>('POST', '/maps/field', body);

  loop = (body: ScenarioRequest) => this.json<Loops>('POST', '/loop', body);
  response = (body: LoopRequest) => this.json<LoopResponse>('POST', '/loop/response', body);
  accuracy = (body: LoopRequest) => this.json<LoopAccuracy>('POST', '/loop/accuracy', body);

  planIdentification = (body: object) =>
    this.json<IdentificationPlan>('POST', '/identify/plan', body);

  jobs = (kind: JobKind) => this.json<JobSummary[]>('GET', `/jobs?kind=${kind}`);
  job = <K extends JobKind>(id: string) => this.json<ReportOf<K>>('GET', `/jobs/${id}`);
  cancelJob = <K extends JobKind>(id: string) => this.json<ReportOf<K>>('DELETE', `/jobs/${id}`);
  /** Asks for work that is always a job. */
  start = <K extends JobKind>(path: string, body: object) =>
    this.json<ReportOf<K>>('POST', path, body);

  async login(token: string): Promise<void> {
    await this.attempt('POST', '/login', { token });
  }

  async logout(): Promise<void> {
    await this.attempt('POST', '/logout');
  }

  private async json<T>(method: string, path: string, body?: object | string): Promise<T> {
    const response = await this.send(method, path, body);
    return (await whole(response.json())) as T;
  }

  private async send(
    method: string,
    path: string,
    body?: object | string,
    signal?: AbortSignal,
  ): Promise<Response> {
    try {
      return await this.attempt(method, path, body, signal);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 401 || !this.onUnauthorized) throw error;
      await this.onUnauthorized();
      return this.attempt(method, path, body, signal);
    }
  }

  private async attempt(
    method: string,
    path: string,
    body?: object | string,
    signal?: AbortSignal,
  ): Promise<Response> {
    const text = typeof body === 'string';
    let response: Response;
    try {
      response = await fetch(ROOT + path, {
        method,
        ...(body === undefined
          ? {}
          : {
              body: text ? body : JSON.stringify(body),
              headers: { 'Content-Type': text ? 'text/plain' : 'application/json' },
            }),
        ...(signal ? { signal } : {}),
      });
    } catch (error) {
      if (signal?.aborted) throw error;
      throw unreachable('The server does not answer.');
    }
    if (!response.ok) throw new ApiError(await readProblem(response), retryAfter(response));
    return response;
  }
}

function unreachable(detail: string): ApiError {
  return new ApiError({ title: 'No answer', status: UNREACHABLE, detail, errors: [] });
}

/** Returns a body, or throws an ApiError where the connection is lost before its end. */
async function whole<T>(body: Promise<T>, signal?: AbortSignal): Promise<T> {
  try {
    return await body;
  } catch (error) {
    if (signal?.aborted) throw error;
    throw unreachable('The connection was lost before the end of the answer.');
  }
}

function retryAfter(response: Response): number | null {
  const seconds = Number.parseFloat(response.headers.get('Retry-After') ?? '');
  return Number.isFinite(seconds) ? 1000 * Math.max(0, seconds) : null;
}

async function readProblem(response: Response): Promise<Problem> {
  const fallback = {
    title: response.statusText || `HTTP ${response.status}`,
    status: response.status,
    detail: '',
    errors: [],
  };
  try {
    return { ...fallback, ...((await response.json()) as Partial<Problem>) };
  } catch {
    return fallback;
  }
}
