import type { KeyTable } from '../../parts/shell/keyboard.svelte';

/** The plane has to have the focus for all but the first two; plane-input.ts handles them. */
export const TRAJECTORY_KEYS: KeyTable = {
  title: 'Trajectories',
  keys: [
    { keys: 'Ctrl+Z', does: 'Undo' },
    { keys: 'Ctrl+Y', does: 'Redo; Ctrl+Shift+Z too' },
    {
      keys: 'Tab',
      does: 'Next point of the plane, with shift the one before; from several to their tools',
    },
    { keys: 'Ctrl+A', does: 'Select all points' },
    { keys: '] [', does: 'Select the next point too; the last one no longer' },
    { keys: 'Arrows', does: 'Move what is selected by 1 mm, with shift 0.1 mm; else the path' },
    { keys: 'Ins', does: 'Add a point after it' },
    { keys: 'Del', does: 'Remove what is selected' },
    { keys: 'Ctrl+V', does: 'Import what was copied: CSV, SVG, G-code or words' },
  ],
};
