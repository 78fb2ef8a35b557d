// node run_module.mjs JOB: instantiate a module, fill its memory, call its functions, write results.
// Prints the processor time of each call, in seconds.

import { readFileSync, writeFileSync } from 'node:fs';

const job = JSON.parse(readFileSync(process.argv[2], 'utf8'));
const memory = new WebAssembly.Memory({ initial: job.pages });
const module = new WebAssembly.Module(readFileSync(job.module));
const { exports } = new WebAssembly.Instance(module, { env: { memory } });
for (const { file, at } of job.arrays) {
  const bytes = readFileSync(file);
  new Uint8Array(memory.buffer, at, bytes.length).set(bytes);
}
const seconds = job.calls.map(([name, ...parameters]) => {
  const before = process.cpuUsage();
  exports[name](...parameters);
  const { user, system } = process.cpuUsage(before);
  return 1e-6 * (user + system);
});
for (const { file, at, size } of job.results) {
  writeFileSync(file, new Uint8Array(memory.buffer, at, size));
}
console.log(JSON.stringify(seconds));
