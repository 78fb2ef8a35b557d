/** REST calls. Every failure is an ApiError that carries the server's problem document. */

import { pretty } from '../../ui/units';
import { person } from '../session/person.svelte';
import { LEASE } from '../storage';
import type { Answer, Method, Operation, Options, PathOf, RequestOf } from './operations';
import type {
  Axis,
  Changes,
  GainSet,
  JobKind,
  Metrics,
  Motor,
  Problem,
  ReportOf,
  Scenario,
  SessionInfo,
  StudyKind,
  Trajectory,
} from './types';

export type { ScenarioRequest } from './operations';

const ROOT = '/api/v1';
const FILE = 'application/octet-stream';

/** No answer at all: the server is down or the network is. */
export const UNREACHABLE = 0;
/** A command without an answer for this long, ms, is said to have none. */
export const PATIENCE = 5000;

export class ApiError extends Error {
  /** @param retryAfter ms to wait before a retry, as the server states; null if it states none */
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

/** How requests reach the server; a demo has files in its place. */
export const network = {
  request: (method: string, path: string, init: RequestInit): Promise<Response> =>
    fetch(ROOT + path, { ...init, method }),
};

interface Sent {
  path?: Readonly<Record<string, string>>;
  query?: Readonly<Record<string, unknown>>;
  header?: Readonly<Record<string, string>>;
  body?: object | string;
}

type Command = 'pause' | 'reset' | 'stop' | 'undo' | 'play' | 'step';
type Play = RequestOf<'/sessions/{session_id}/play'>;
type Step = RequestOf<'/sessions/{session_id}/step'>;

const RESOLUTION = { positions: 97, currents: 11 };

/** Operations that are always a job. */
export type StudyPath = Extract<
  PathOf<'post'>,
  | '/tune'
  | '/landscape'
  | '/friction-models'
  | '/safe-tune'
  | '/identify'
  | '/learn'
  | '/minute'
  | '/montecarlo'
  | '/reproduce'
  | '/response'
  | '/shape'
  | '/sensitivity'
  | '/sweep'
>;

export class Api {
  /** Prompts for the token when the server requires one; resolves once it is accepted. */
  onUnauthorized: (() => Promise<void>) | null = null;

  health = (signal?: AbortSignal) => this.json('get', '/health', {}, signal);
  scenarios = () => this.json('get', '/scenarios', {});
  scenario = (name: string) => this.json('get', '/scenarios/{name}', { path: { name } });
  fields = () => this.json('get', '/fields', {});
  requestFields = (kind: StudyKind) => this.json('get', '/fields/{kind}', { path: { kind } });
  parts = () => this.json('get', '/parts', {});
  paper = () => this.json('get', '/paper', {});
  parse = (toml: string) => this.json('post', '/scenarios/parse', { body: toml });
  create = (body: RequestOf<'/sessions'>) => this.json('post', '/sessions', { body });
  session = (id: string, signal?: AbortSignal) =>
    this.json('get', '/sessions/{session_id}', at(id), signal);
  remove = (id: string) => this.json('delete', '/sessions/{session_id}', at(id));
  // Only some variants and axes may have metrics yet.
  metrics = (id: string) =>
    this.json(
      'get',
      '/sessions/{session_id}/metrics',
      at(id),
    ) as Promise<unknown> as Promise<Metrics>;

  /** A command that is not repeated: without an answer it is said not to have one. */
  command(id: string, name: 'pause' | 'reset' | 'undo'): Promise<SessionInfo>;
  command(id: string, name: 'play', body: Play): Promise<SessionInfo>;
  command(id: string, name: 'step', body: Step): Promise<SessionInfo>;
  command(id: string, name: 'stop', body: object, signal: AbortSignal): Promise<SessionInfo>;
  async command(
    id: string,
    name: Command,
    body: object = {},
    signal = AbortSignal.timeout(PATIENCE),
  ): Promise<SessionInfo> {
    const sent = { ...at(id), ...actor(), body };
    const answer = await this.send('post', `/sessions/{session_id}/${name}`, sent, signal);
    return whole(answer.json(), signal) as Promise<SessionInfo>;
  }

  laws = () => this.json('get', '/laws', {});
  lawCost = (name: string) => this.json('get', '/laws/{name}/cost', { path: { name } });
  /** Has another version of a law's file run, in all sessions. */
  moveLaw = (name: string, where: 'back' | 'forward') =>
    this.json('post', `/laws/{name}/${where}`, { path: { name }, ...actor() });
  /** Writes the file of a law, which holds what `digest` says. */
  putLaw = (name: string, text: string, digest: string) =>
    this.json('put', '/laws/{name}', {
      path: { name },
      ...holding(digest),
      body: { text },
    });
  earlierEvents = (id: string) => this.json('get', '/sessions/{session_id}/earlier-events', at(id));

  push = (id: string, body: { axis: Axis; force: number; duration: number }) =>
    this.json('post', '/sessions/{session_id}/push', {
      ...at(id),
      ...actor(),
      body,
    });
  /** Keeps ticks [from, to) as a run. */
  keepCapture = (id: string, body: RequestOf<'/sessions/{session_id}/captures'>) =>
    this.json('post', '/sessions/{session_id}/captures', { ...at(id), body });
  patch = (id: string, set: Changes) =>
    this.json('patch', '/sessions/{session_id}/parameters', {
      ...at(id),
      ...actor(),
      body: { set },
    });

  async whatif(body: RequestOf<'/whatif'>, signal: AbortSignal) {
    const response = await this.send('post', '/whatif', { body }, signal);
    return whole(response.arrayBuffer(), signal);
  }

  async whatifLanes(body: RequestOf<'/whatif/lanes'>, signal: AbortSignal) {
    const response = await this.send('post', '/whatif/lanes', { body }, signal);
    return whole(response.arrayBuffer(), signal);
  }

  trajectories = () => this.json('get', '/trajectories', {});
  trajectory = (name: string) => this.json('get', '/trajectories/{name}', { path: { name } });
  keepTrajectory = (name: string, body: Trajectory) =>
    this.json('put', '/trajectories/{name}', { path: { name }, body });
  dropTrajectory = (name: string) =>
    this.json('delete', '/trajectories/{name}', { path: { name } });
  slow = (body: RequestOf<'/trajectories/slow'>) =>
    this.json('post', '/trajectories/slow', { body });

  async check(body: RequestOf<'/trajectories/check'>) {
    return whole((await this.send('post', '/trajectories/check', { body })).arrayBuffer());
  }

  gainSets = () => this.json('get', '/gain-sets', {}) as Promise<unknown> as Promise<GainSet[]>;
  keepGainSet = (
    name: string,
    body: { scenario: Scenario | string; values: Changes; note: string },
  ) => this.json('put', '/gain-sets/{name}', { path: { name }, body });
  layouts = () => this.json('get', '/layouts', {});
  keepLayout = (name: string, body: { scopes: string[] }) =>
    this.json('put', '/layouts/{name}', { path: { name }, body });
  deleteLayout = (name: string) => this.json('delete', '/layouts/{name}', { path: { name } });

  dropGainSet = (name: string) => this.json('delete', '/gain-sets/{name}', { path: { name } });

  platform = (body: RequestOf<'/design/platform'>) =>
    this.json('post', '/design/platform', { body });
  design = (body: RequestOf<'/design'>) => this.json('post', '/design', { body });

  maps = () => this.json('get', '/maps', {});
  map = (name: string) => this.json('get', '/maps/{name}', { path: { name }, query: RESOLUTION });
  dropMap = (name: string) => this.json('delete', '/maps/{name}', { path: { name } });
  /** A job, or at once the entry of a map that was computed before. */
  computeMap = (body: RequestOf<'/maps'>) => this.json('post', '/maps', { body });
  previewMap = (body: RequestOf<'/maps/preview'>) =>
    this.json('post', '/maps/preview', { query: RESOLUTION, body });
  fitMap = (name: string) => this.json('get', '/maps/{name}/fit', { path: { name } });
  shareForce = (body: RequestOf<'/design/sharing'>) =>
    this.json('post', '/design/sharing', { body });
  mapField = (body: RequestOf<'/maps/field'>) => this.json('post', '/maps/field', { body });

  motors = () => this.json('get', '/motors', {});
  motor = (name: string) => this.json('get', '/motors/{name}', { path: { name } });
  keepMotor = (name: string, body: Motor) =>
    this.json('put', '/motors/{name}', { path: { name }, body });
  dropMotor = (name: string) => this.json('delete', '/motors/{name}', { path: { name } });

  loop = (body: RequestOf<'/loop'>) => this.json('post', '/loop', { body });
  why = (body: RequestOf<'/why'>) => this.json('post', '/why', { body });
  response = (body: RequestOf<'/loop/response'>) => this.json('post', '/loop/response', { body });
  accuracy = (body: RequestOf<'/loop/accuracy'>) => this.json('post', '/loop/accuracy', { body });

  planIdentification = (body: RequestOf<'/identify/plan'>) =>
    this.json('post', '/identify/plan', { body });

  jobs = (kind: JobKind) => this.json('get', '/jobs', { query: { kind } });
  jobsNow = () => this.json('get', '/jobs/now', {});
  job = <K extends JobKind>(job_id: string) =>
    this.json('get', '/jobs/{job_id}', { path: { job_id } }) as Promise<ReportOf<K>>;
  cancelJob = <K extends JobKind>(job_id: string) =>
    this.json('delete', '/jobs/{job_id}', { path: { job_id } }) as Promise<ReportOf<K>>;
  /** Asks for work that is always a job. */
  start = <K extends JobKind, P extends StudyPath>(path: P, body: RequestOf<P>) =>
    this.send('post', path, { body: body as object }).then((answer) =>
      whole(answer.json()),
    ) as Promise<ReportOf<K>>;

  async login(token: string): Promise<void> {
    await this.attempt('post', '/login', { body: { token } });
  }

  async logout(): Promise<void> {
    await this.attempt('post', '/logout', {});
  }

  /** Any call that is answered as JSON; screens have those here that only they make. */
  async json<M extends Method, P extends PathOf<M>>(
    method: M,
    path: P,
    options: Options<Operation<M, P>>,
    signal?: AbortSignal,
  ): Promise<Answer<Operation<M, P>>> {
    const response = await this.send(method, path, options as Sent, signal);
    if (response.status === 204) return undefined as Answer<Operation<M, P>>;
    return (await whole(response.json(), signal)) as Answer<Operation<M, P>>;
  }

  /** A call that is answered in bytes. */
  async bytes<P extends PathOf<M>, M extends Method = 'get'>(
    path: P,
    options: Options<Operation<M, P>>,
    method = 'get' as M,
  ) {
    return whole((await this.send(method, path, options as Sent)).arrayBuffer());
  }

  private async send(
    method: Method,
    path: string,
    sent: Sent,
    signal?: AbortSignal,
  ): Promise<Response> {
    try {
      return await this.attempt(method, path, sent, signal);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 401 || !this.onUnauthorized) throw error;
      await this.onUnauthorized();
      return this.attempt(method, path, sent, signal);
    }
  }

  private async attempt(
    method: Method,
    path: string,
    { path: parts = {}, query = {}, header = {}, body }: Sent,
    signal?: AbortSignal,
  ): Promise<Response> {
    const text = typeof body === 'string';
    const file = body instanceof Blob;
    const place = path.replace(/\{(\w+)\}/g, (_, name: string) => parts[name] ?? '');
    const pairs = Object.entries(query).flatMap(([name, value]) =>
      [value].flat().map((each) => [name, String(each)]),
    );
    const search = new URLSearchParams(pairs).toString();
    let response: Response;
    try {
      response = await network.request(method.toUpperCase(), place + (search && `?${search}`), {
        headers: {
          ...header,
          ...(body === undefined
            ? {}
            : { 'Content-Type': text ? 'text/plain' : file ? FILE : 'application/json' }),
        },
        ...(body === undefined ? {} : { body: text || file ? body : JSON.stringify(body) }),
        ...(signal ? { signal } : {}),
      });
    } catch (error) {
      throw noAnswer(error, signal, 'The server does not answer.');
    }
    if (!response.ok) throw new ApiError(await readProblem(response), retryAfter(response));
    return response;
  }
}

/** The path of one session. */
function at(session_id: string) {
  return { path: { session_id } };
}

/** Who acts; and control of the drives, where this page holds it: without it only STOP acts on them. */
function actor(): { header: Record<string, string> } {
  const Lease = sessionStorage.getItem(LEASE);
  return { header: { ...(Lease === null ? {} : { Lease }), ...person.header } };
}

/** What a file is known to hold, or it is not written. */
function holding(digest: string): { header: Record<string, string> } {
  return { header: { 'If-Match': digest } };
}

function unreachable(detail: string): ApiError {
  return new ApiError({ title: 'No answer', status: UNREACHABLE, detail, errors: [] });
}

/** Returns a body, or throws an ApiError where the connection is lost before its end. */
async function whole<T>(body: Promise<T>, signal?: AbortSignal): Promise<T> {
  try {
    return await body;
  } catch (error) {
    throw noAnswer(error, signal, 'The connection was lost before the end of the answer.');
  }
}

/** Returns why there is no answer; the error itself where the caller has withdrawn the request. */
function noAnswer(error: unknown, signal: AbortSignal | undefined, detail: string): unknown {
  if (!signal?.aborted) return unreachable(detail);
  const late = (signal.reason as Error | undefined)?.name === 'TimeoutError';
  return late ? unreachable('The server has not answered in time.') : error;
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
