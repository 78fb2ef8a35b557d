/** The Monte Carlo study, which is loaded when its panel is first opened. */

export { study } from './study.svelte';
export { default as StudyBody } from './StudyBody.svelte';
