import type { KeyTable } from '../../app/keys';

/** The plane has to have the focus for all but the first two; plane-input.ts handles them. */
export const TRAJECTORY_KEYS: KeyTable = {
  title: 'Trajectories',
  keys: [
    { keys: 'Ctrl+Z', does: 'Undo' },
    { keys: 'Ctrl+Y', does: 'Redo; Ctrl+Shift+Z too' },
    { keys: 'Tab', does: 'Next point of the plane, with shift the one before' },
    { keys: 'Arrows', does: 'Move the point by 1 mm, with shift by 0.1 mm; without one the path' },
    { keys: 'Ins', does: 'Add a point after it' },
    { keys: 'Del', does: 'Remove it' },
  ],
};
