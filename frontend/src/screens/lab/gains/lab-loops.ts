/** The loops of the controllers that the Lab shows. */

import { LoopMargins } from '../../../app/loop/loops.svelte';
import { app } from '../../../app/store.svelte';

export const labLoops = new LoopMargins(app.api);
