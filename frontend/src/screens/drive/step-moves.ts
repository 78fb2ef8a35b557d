/** What a step of commissioning moves, how far and how strongly; as backend/motionlab/drive/commissioning does it. */

import type { DriveStatus } from '../../app/api/types';
import { digits } from '../../ui/units';

export interface Announced {
  name: 'moves' | 'how far' | 'how fast' | 'how strong';
  text: string;
}

/** Shares of the largest current: of one phase alone, and of a field that draws the mover. */
const ALONE = 0.1;
const DRAW = 0.3;

/** Returns the rows of the question before a step; none for one that is not known here. */
export function announced(step: string, { axes }: DriveStatus): Announced[] {
  const current = (share: number) => {
    const values = axes.map(({ limits }) => digits(share * limits.current_max));
    return `${[...new Set(values)].join(' and ')} A a phase`;
  };
  switch (step) {
    case 'currents':
      return rows('each phase alone may draw the mover', 'within a pole pitch', '', current(ALONE));
    case 'commutation':
      return rows('x, then y', 'a pole pitch up and down', '', current(DRAW));
    case 'homing':
      return rows('x, then y', 'to both end stops, then to the middle', '10 mm/s', current(DRAW));
    case 'hold':
      return rows('x, then y', '2 mm and back', '5 mm/s', `${current(1)} at most, low gains`);
    case 'friction':
      return rows('x and y', 'up to 30 mm and back', 'up to 80 mm/s', `${current(1)} at most`);
    default:
      return [];
  }
}

function rows(moves: string, far: string, fast: string, strong: string): Announced[] {
  const all: Announced[] = [
    { name: 'moves', text: moves },
    { name: 'how far', text: far },
    { name: 'how fast', text: fast },
    { name: 'how strong', text: strong },
  ];
  return all.filter(({ text }) => text !== '');
}
