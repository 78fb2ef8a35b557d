/** Why an error peaks: loaded when it is first asked. */

export { why } from './why.svelte';
export { default as WhySheet } from './WhySheet.svelte';
