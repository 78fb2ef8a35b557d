/** REST calls. Every failure is an ApiError that carries the server's problem document. */

import type {
  Changes,
  Metrics,
  Parts,
  Problem,
  Scenario,
  ScenarioEntry,
  SessionInfo,
  Axis,
} from './types';

const ROOT = '/api/v1';

export class ApiError extends Error {
  constructor(readonly problem: Problem) {
    super(problem.detail || problem.title);
  }

  get status(): number {
    return this.problem.status;
  }
}

/** No answer at all: the server is down or the network is. */
export const UNREACHABLE = 0;

export interface ScenarioRequest {
  scenario?: string | Scenario;
  set?: Changes;
}

export class Api {
  /** Asks for the token when the server wants one; resolves once a token was accepted. */
  onUnauthorized: (() => Promise<void>) | null = null;

  scenarios = () => this.json<ScenarioEntry[]>('GET', '/scenarios');
  scenario = (name: string) => this.json<Scenario>('GET', `/scenarios/${name}`);
  parts = () => this.json<Parts>('GET', '/parts');
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

  async whatif(body: ScenarioRequest & { columns: string[]; points: number }, signal: AbortSignal) {
    const response = await this.send('POST', '/whatif', body, signal);
    return response.arrayBuffer();
  }

  async login(token: string): Promise<void> {
    await this.attempt('POST', '/login', { token });
  }

  private async json<T>(method: string, path: string, body?: object | string): Promise<T> {
    const response = await this.send(method, path, body);
    return (await response.json()) as T;
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
      throw new ApiError({
        title: 'No answer',
        status: UNREACHABLE,
        detail: 'The server does not answer.',
        errors: [],
      });
    }
    if (!response.ok) throw new ApiError(await readProblem(response));
    return response;
  }
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
