/** What sizing is asked with, in the order of its form. */

import type { Changes, DesignDocument, Reading } from '../../../app/api/types';
import type { Group } from '../quantity-fields';

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

/** What a design needs beyond the paper's choices. */
export const BORROWED = /\.(l_m|N|single_phase_force|two_phase_force|mass|stroke)$/;

/** Tooth, slot and their ratio: of these the last one that was typed holds, the pitch with it. */
const TEETH = ['p', 's', 'sigma'];

/** Takes one number; of tooth, slot and ratio the others then follow from the pitch. */
export function withTooth(set: Changes, path: string, value: number): Changes {
  const [of, name] = path.split('.') as [string, string];
  const dropped = TEETH.includes(name) ? TEETH.map((one) => `${of}.${one}`) : [];
  const kept = Object.entries(set).filter(([key]) => !dropped.includes(key));
  return { ...Object.fromEntries(kept), [path]: value };
}

export interface Section {
  title: string;
  readings: Reading[];
}

function isReading(value: unknown): value is Reading {
  return typeof value === 'object' && value !== null && 'used_form' in value;
}

const readingsOf = (table: object): Reading[] => Object.values(table).filter(isReading);

export function sectionsOf(design: DesignDocument, direction: Direction): Section[] {
  if (direction === 'requirements') return [{ title: '', readings: readingsOf(design.sizing) }];
  const { rating } = design;
  if (!rating) return [];
  return [
    { title: 'Axis x', readings: readingsOf(rating.x) },
    { title: 'Axis y', readings: readingsOf(rating.y) },
    { title: 'Motor', readings: readingsOf(rating) },
  ];
}

/** A printed number agrees if it is ours but for its last digit. */
const ROUNDING = 0.005;
const NUMBER_ONLY = 'a number without formula';

/** Whether what is used is another formula or another number than what is printed. */
export function differs({ printed_form, used_form, printed_value, value }: Reading): boolean {
  if (printed_form === '' || printed_form === used_form) return false;
  if (!printed_form.startsWith('M = ') && printed_form !== NUMBER_ONLY) return true;
  if (printed_value === null || value === null) return false;
  return Math.abs(printed_value - value) > ROUNDING * Math.abs(value);
}
