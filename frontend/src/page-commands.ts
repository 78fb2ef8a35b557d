/** What the sheets of keys and commands list of the present screen. */

import { screen } from './app/screen.svelte';
import { ofKeys, type Command } from './parts/shell/commands';
import { screenKeys } from './parts/shell/keyboard.svelte';
import { tour } from './parts/tour/tour.svelte';
import { LAB_KEYS, SCENE_KEYS } from './screens/lab/lab-key-table';
import { labActions } from './screens/lab/lab-keys';
import { view } from './screens/lab/scopes/view.svelte';
import { TRAJECTORY_KEYS } from './screens/trajectories/editor-keys';

/** Returns the columns of the help sheet. */
export function keyTables() {
  return { left: [LAB_KEYS], right: [SCENE_KEYS, screenKeys.table ?? TRAJECTORY_KEYS] };
}

/** What is found besides screens and controls: what keys do, and the channels of the scopes. */
export function commands(): Command[] {
  const { table, actions } = screenKeys;
  const guide = {
    name: 'Tour in five steps',
    place: 'help',
    key: '',
    about: 'guide introduction first steps getting started',
    run: () => void tour.start(),
  };
  if (screen.current !== 'lab') return [guide, ...(table ? ofKeys(table, actions) : [])];
  const channels = view.known.map(({ name, meaning = '' }) => ({
    name: `${name}${meaning && `, ${meaning}`}`,
    place: 'channel, in a new scope',
    key: '',
    run: () => view.layout.add(name),
  }));
  return [guide, ...ofKeys(LAB_KEYS, labActions()), ...channels];
}
