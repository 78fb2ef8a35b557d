import { describe, expect, it } from 'vitest';
import { takenBack, targetsOf } from './rules';

describe('what the tour staged', () => {
  const staged = { changes: { law: 'published-k' }, before: { mass: 6 } };

  it('goes, and what others staged stays', () => {
    expect(takenBack({ law: 'published-k', mass: 6, seed: 7 }, staged)).toEqual({
      mass: 6,
      seed: 7,
    });
  });

  it('gives way to what stood there before', () => {
    const before = { law: 'off' };
    expect(takenBack({ law: 'published-k' }, { ...staged, before })).toEqual({ law: 'off' });
  });

  it('stays where somebody has changed it since', () => {
    expect(takenBack({ law: 'residual-k' }, staged)).toEqual({ law: 'residual-k' });
  });
});

describe('what is outlined', () => {
  it('is the way to another screen, there what the step speaks of', () => {
    const step = { screen: 'drive', targets: 'main .state' } as const;
    expect(targetsOf(step, 'lab')).toBe('nav a[href="?screen=drive"]');
    expect(targetsOf(step, 'drive')).toBe('main .state');
  });
});
