/** Files of other programs: read as a trajectory and written from one, by the server. */

import type { components, operations } from '../../../app/api/schema';
import { app } from '../../../app/store.svelte';
import { saveFile } from '../../../ui/export';
import type { Editor } from '../editor.svelte';

export type ReadQuery = NonNullable<operations['importTrajectory']['parameters']['query']>;
export type FileFormat = NonNullable<ReadQuery['format']>;
export type ReadFile = components['schemas']['ReadTrajectory'];
export type WrittenFormat = components['schemas']['WriteRequest']['format'];

/** What is written, as a person chooses it. */
export const WRITTEN: readonly {
  format: WrittenFormat;
  name: string;
  title: string;
  ending: string;
  type: string;
}[] = [
  {
    format: 'csv',
    name: 'CSV, every tick',
    title: 'Time, x and y at every control tick, 2000 a second',
    ending: 'csv',
    type: 'text/csv',
  },
  {
    format: 'points',
    name: 'CSV, points',
    title: 'x and y of the points',
    ending: 'csv',
    type: 'text/csv',
  },
  {
    format: 'svg',
    name: 'SVG',
    title: 'Lines and cubic curves, exactly the path',
    ending: 'svg',
    type: 'image/svg+xml',
  },
  {
    format: 'gcode',
    name: 'G-code',
    title: 'One lap: lines within 1 µm of the curve, feed and dwells',
    ending: 'ngc',
    type: 'text/plain',
  },
];

/** Reads a file as a trajectory; nothing is kept. */
export const readFile = (body: Blob, query: ReadQuery) =>
  app.api.json('post', '/trajectories/import', { body, query });

/** Gives the user the path of the editor as a file. */
export async function saveAs(editor: Editor, format: WrittenFormat): Promise<void> {
  const written = WRITTEN.find((each) => each.format === format);
  if (!written) return;
  await app.try(async () => {
    const body = { ...editor.planned(editor.table), format };
    const content = await app.api.bytes('/trajectories/export', { body }, 'post');
    saveFile(`${fileStem(editor)}.${written.ending}`, written.type, content);
  });
}

/** Returns the name of a file without its ending: that of the path, or its kind. */
function fileStem({ name, table }: Editor): string {
  const stem = /^[a-z0-9-]{1,64}$/.test(name) ? name : String(table.kind);
  return stem.replaceAll('_', '-');
}
