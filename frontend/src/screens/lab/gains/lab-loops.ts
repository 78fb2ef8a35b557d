/** The loops of the controllers that the Lab shows. */

import { LoopMargins } from '../../../parts/loop/loops.svelte';
import { app } from '../../../app/store.svelte';

export const labLoops = new LoopMargins(app.api);
