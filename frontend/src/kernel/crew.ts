/** Workers that run the kernel, each some of the variants. */

import type { About } from './module';
import { aboutOf, hasSimd } from './module';
import type { Answer, Envelope, Inputs, Reply, Request } from './tasks';

/** Workers: one a variant of a comparison. */
const COUNT = 2;
/** Most memory of all workers together, bytes. */
const MOST = 64e6;
/** A worker that has not answered for so long has ended, ms: one without memory may not say so. */
const LONGEST = 30_000;

/** The worker has ended and will not answer. */
export class WorkerEnded extends Error {}

/** What a worker is to the page; tests put another in its place. */
export interface Port {
  post(request: Request): Promise<Answer>;
  end(): void;
}

/** A worker whose answers come in the order of its requests. */
export class WorkerPort implements Port {
  private next = 0;
  private readonly waiting = new Map<
    number,
    { resolve: (answer: Answer) => void; reject: (error: Error) => void }
  >();
  private ended: WorkerEnded | null = null;
  /** Starts with each answer anew. */
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(private readonly worker: Worker) {
    worker.onmessage = ({ data }: MessageEvent<Reply>) => {
      const caller = this.waiting.get(data.id);
      this.waiting.delete(data.id);
      this.watch();
      if ('error' in data) caller?.reject(new Error(data.error));
      else caller?.resolve(data.answer);
    };
    worker.onerror = () => this.fail('a worker of the page has ended');
    worker.onmessageerror = () => this.fail('an answer of a worker cannot be read');
  }

  post(request: Request): Promise<Answer> {
    if (this.ended) return Promise.reject(this.ended);
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      if (this.waiting.size === 1) this.watch();
      this.worker.postMessage({ id, request } satisfies Envelope);
    });
  }

  end(): void {
    this.fail('the worker was ended');
  }

  private watch(): void {
    clearTimeout(this.timer);
    if (this.waiting.size === 0) return;
    this.timer = setTimeout(() => this.fail('a worker of the page does not answer'), LONGEST);
  }

  private fail(reason: string): void {
    this.worker.terminate();
    this.ended ??= new WorkerEnded(reason);
    for (const { reject } of this.waiting.values()) reject(this.ended);
    this.waiting.clear();
    this.watch();
  }
}

export class Crew {
  /** Key of the inputs that each worker has. */
  private readonly known: string[];

  private constructor(
    readonly about: About,
    private readonly ports: readonly Port[],
  ) {
    this.known = ports.map(() => '');
  }

  /** Opens workers on a module. */
  static async of(module: WebAssembly.Module, ports: readonly Port[]): Promise<Crew> {
    const most = MOST / ports.length;
    await Promise.all(ports.map((port) => port.post({ kind: 'open', module, most })));
    return new Crew(aboutOf(module), ports);
  }

  /** Loads the module and opens workers in this browser. */
  static async open(): Promise<Crew> {
    if (!hasSimd()) throw new Error('this browser has no WebAssembly with SIMD');
    const url = new URL('../../kernel.wasm', import.meta.url);
    // Not compileStreaming: it refuses a host that does not name the type application/wasm.
    const module = await WebAssembly.compile(await (await fetch(url)).arrayBuffer());
    const worker = () => new Worker(new URL('./worker.ts', import.meta.url), { type: 'module' });
    return Crew.of(
      module,
      Array.from({ length: COUNT }, () => new WorkerPort(worker())),
    );
  }

  /**
   * Sends each variant's request to its worker, after the inputs that it lacks.
   *
   * @param requests of each variant, null where it needs none
   */
  async each<T extends Answer>(
    inputs: Inputs,
    requests: readonly (Request | null)[],
  ): Promise<(T | null)[]> {
    const { known } = this;
    const sent: Promise<Answer>[] = [];
    const answers = requests.map((request, i) => {
      if (!request) return null;
      const place = i % this.ports.length;
      const port = this.ports[place] as Port;
      if (known[place] !== inputs.key) {
        known[place] = inputs.key;
        sent.push(port.post({ kind: 'inputs', inputs }));
      }
      return port.post(request) as Promise<T>;
    });
    try {
      await Promise.all(sent);
      return await Promise.all(answers);
    } catch (error) {
      known.fill(''); // a worker that lacks memory for inputs has none
      await Promise.allSettled([...sent, ...answers]);
      throw error;
    }
  }

  end(): void {
    for (const port of this.ports) port.end();
  }
}
