/** Keys of the Lab screen, as they are listed. */

import type { KeyTable } from '../../parts/shell/keyboard.svelte';

export const LAB_KEYS: KeyTable = {
  title: 'Lab',
  keys: [
    { keys: 'Space', does: 'Play or pause' },
    { keys: 's, S', does: 'Step one tick (0.5 ms), or 100 ms' },
    { keys: 'r', does: 'Reset to 0 s' },
    { keys: '[ ]', does: 'Slower, faster' },
    { keys: 'w, l', does: 'Staged, in the motor' },
    { keys: 'u', does: 'Undo the last change' },
    { keys: 'b, B', does: 'Law of one’s own: run the version before, or the one after' },
    { keys: 'a', does: 'Send what is staged to the motor' },
    { keys: '1 to 9', does: 'Bring a scope forward' },
    { keys: 'n', does: 'New scope: choose its channels' },
    { keys: '/', does: 'Find a channel for the first scope' },
    { keys: '+ −', does: 'Zoom the time axis about the pointer or its middle' },
    { keys: ', .', does: 'Move the time axis' },
    { keys: 'j, J', does: 'Jump to the next mark on the time axis, or the one before' },
    { keys: 'k, K', does: 'Cursor to the next peak of a trace, or the one before' },
    { keys: 'm', does: 'Set cursor 1, then cursor 2, then clear both' },
    { keys: 'V', does: 'Cursors at the least and the largest value' },
    { keys: 'M', does: 'All readings as a table' },
    { keys: '< >', does: 'Move the cursor that was set last' },
    { keys: 'h, H', does: 'Trigger: arm it, or find hits; off' },
    { keys: 'v', does: 'Readings tell the value, mean, RMS, peak to peak, std' },
    { keys: '0', does: 'Reset zoom and cursors' },
    { keys: 'o', does: 'Overlay runs' },
    { keys: 'F', does: 'Scopes over the whole page, or back; the 3-D view where that is open' },
    { keys: 'c', does: 'Next camera of the 3-D view' },
    { keys: 'f', does: 'Value axes follow the data, or hold' },
  ],
};

/** While the 3-D view has the focus; all other keys of the Lab act there too. */
export const SCENE_KEYS: KeyTable = {
  title: '3-D view',
  keys: [
    {
      keys: 'w a s d q e',
      does: 'Move the camera (Tab into the view first), in place of w, a and s',
    },
    { keys: 'Arrows', does: 'Turn the camera' },
  ],
};
