// A job: instantiate a module, fill its memory, call its functions, take what they wrote.

/**
 * Return the time of each call, in seconds, and the bytes of each result.
 *
 * `read` gives the bytes of a file of the job's folder, `clock` the time in seconds.
 */
export async function carryOut(job, read, clock) {
  const memory = new WebAssembly.Memory({ initial: job.pages });
  const module = await WebAssembly.compile(await read(job.module));
  const { exports } = await WebAssembly.instantiate(module, { env: { memory } });
  for (const { file, at } of job.arrays) {
    new Uint8Array(memory.buffer).set(await read(file), at);
  }
  const seconds = job.calls.map(([name, ...parameters]) => {
    const before = clock();
    exports[name](...parameters);
    return clock() - before;
  });
  const results = job.results.map(({ at, size }) => new Uint8Array(memory.buffer, at, size));
  return { seconds, results };
}
