/** The Lab on drives, which is loaded where the server has a drive link. */

export { driveRuns } from './drive-runs.svelte';
export { default as DriveTransport } from './DriveTransport.svelte';
export { default as MachineChoice } from './MachineChoice.svelte';
