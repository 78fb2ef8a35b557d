/** What sizing is asked with, in the order of its form. */

import { fieldAt, type Field, type Group, type Numbers } from '../quantity-fields';

export type Direction = 'requirements' | 'dimensions';

const SHARED: readonly [title: string, names: readonly string[]][] = [
  ['Specified for one phase', ['f_max', 'v_max', 'i']],
  ['Teeth', ['tau', 'p', 's', 'sigma', 'n', 'limbs']],
  [
    'Magnetic circuit',
    ['g', 'B_g', 'H_a', 'l_a', 'lambda', 'K_e', 'K_d', 'loading_min', 'loading_max'],
  ],
];
const AXIS = ['mass', 'platform_mass', 'stroke'];
const MACHINE = [
  ...['l_m', 'N', 'single_phase_force', 'two_phase_force'],
  ...['x', 'y'].flatMap((axis) => AXIS.map((name) => `${axis}.${name}`)),
];

const groups = (of: Direction, more: typeof SHARED = []): Group[] =>
  [...more, ...SHARED].map(([title, names]) => ({
    title,
    paths: names.map((name) => `${of}.${name}`),
  }));

export const GROUPS: Record<Direction, readonly Group[]> = {
  requirements: groups('requirements'),
  dimensions: groups('dimensions', [['Machine', MACHINE]]),
};

export const fieldsOf = (direction: Direction): Field[] =>
  GROUPS[direction].flatMap(({ paths }) => paths.map((path) => fieldAt('design', path)));

/** Tooth, slot and their ratio: of these the last one that was typed holds, the pitch with it. */
const TEETH = ['p', 's', 'sigma'];

/** Takes one number; of tooth, slot and ratio the others then follow from the pitch. */
export function taken(set: Numbers, path: string, value: number): Numbers {
  const [of, name] = path.split('.') as [string, string];
  const dropped = TEETH.includes(name) ? TEETH.map((one) => `${of}.${one}`) : [];
  const kept = Object.entries(set).filter(([key]) => !dropped.includes(key));
  return { ...Object.fromEntries(kept), [path]: value };
}

/** Takes one number back, so that the preset's holds. */
export function dropped(set: Numbers, path: string): Numbers {
  return Object.fromEntries(Object.entries(set).filter(([key]) => key !== path));
}
