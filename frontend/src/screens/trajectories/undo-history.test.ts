import { describe, expect, it } from 'vitest';
import { History } from './undo-history';

describe('history', () => {
  it('goes back and forth', () => {
    const history = new History<number>();
    history.keep(0, '', 0);
    history.keep(1, '', 1);
    expect(history.undo(2)).toBe(1);
    expect(history.undo(1)).toBe(0);
    expect(history.undo(0)).toBe(0);
    expect(history.redo(0)).toBe(1);
    expect(history.redo(1)).toBe(2);
    expect(history.redo(2)).toBe(2);
  });

  it('takes a drag as one step, however long it takes', () => {
    const history = new History<number>();
    history.keep(0, 'drag 1', 0);
    history.keep(1, 'drag 1', 9000);
    history.pause();
    history.keep(2, 'drag 2', 9001);
    expect(history.undo(3)).toBe(2);
    expect(history.undo(2)).toBe(0);
    expect(history.canUndo).toBe(false);
  });

  it('takes nudges as one step only while they follow quickly', () => {
    const history = new History<number>();
    history.keep(0, 'nudge 1', 0);
    history.keep(1, 'nudge 1', 500);
    history.keep(2, 'nudge 1', 2000);
    expect(history.undo(3)).toBe(2);
    expect(history.undo(2)).toBe(0);
  });

  it('forgets what was undone when something new is done', () => {
    const history = new History<number>();
    history.keep(0, '', 0);
    history.undo(1);
    history.keep(0, '', 1);
    expect(history.canRedo).toBe(false);
  });
});
