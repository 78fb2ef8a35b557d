// node run_module.mjs FOLDER: carry out the job in a folder, and write its results there.
// Prints the processor time of each call, in seconds.

import { readFileSync, writeFileSync } from 'node:fs';
import { carryOut } from './module_job.mjs';

const folder = process.argv[2];
const read = (name) => readFileSync(`${folder}/${name}`);
const job = JSON.parse(read('job.json'));
const { seconds, results } = await carryOut(job, read, () => {
  const { user, system } = process.cpuUsage();
  return 1e-6 * (user + system);
});
results.forEach((bytes, index) => writeFileSync(`${folder}/${job.results[index].file}`, bytes));
console.log(JSON.stringify(seconds));
