/** What sizing is asked with, in the order of its form. Ranges are the server's. */

import type { Field, Numbers } from '../quantity-fields';

export type Direction = 'requirements' | 'dimensions';

export interface Group {
  title: string;
  fields: Field[];
}

const MM = { factor: 1e3, unit: 'mm' };
const KILO = { factor: 1e-3, unit: 'kA/m' };

const shared = (of: Direction): Group[] => [
  {
    title: 'Specified for one phase',
    fields: [
      { path: `${of}.f_max`, label: 'Thrust', symbol: 'f_max', unit: 'N' },
      { path: `${of}.v_max`, label: 'Velocity', symbol: 'v_max', unit: 'm/s' },
      { path: `${of}.i`, label: 'Current', symbol: 'i', unit: 'A' },
    ],
  },
  {
    title: 'Teeth',
    fields: [
      { path: `${of}.tau`, label: 'Pole pitch', symbol: 'tau', ...MM },
      { path: `${of}.p`, label: 'Tooth', symbol: 'p', ...MM },
      { path: `${of}.s`, label: 'Slot', symbol: 's', ...MM },
      { path: `${of}.sigma`, label: 'Tooth over slot', symbol: 'sigma' },
      { path: `${of}.n`, label: 'Teeth per limb', symbol: 'n', whole: true },
      { path: `${of}.limbs`, label: 'Limbs', whole: true },
    ],
  },
  {
    title: 'Magnetic circuit',
    fields: [
      { path: `${of}.g`, label: 'Air gap', symbol: 'g', ...MM },
      { path: `${of}.B_g`, label: 'Flux density', symbol: 'B_g', unit: 'T' },
      { path: `${of}.H_a`, label: 'Field in the iron', symbol: 'H_a', ...KILO },
      { path: `${of}.l_a`, label: 'Path in the iron', symbol: 'l_a', ...MM },
      { path: `${of}.lambda`, label: 'Inductance ratio', symbol: 'lambda' },
      { path: `${of}.K_e`, label: 'Efficiency', symbol: 'K_e' },
      { path: `${of}.K_d`, label: 'Duty cycle', symbol: 'K_d' },
      { path: `${of}.loading_min`, label: 'Loading, least', ...KILO },
      { path: `${of}.loading_max`, label: 'Loading, most', ...KILO },
    ],
  },
];

const axis = (of: 'x' | 'y'): Field[] => [
  { path: `dimensions.${of}.mass`, label: `Moving mass ${of}`, unit: 'kg' },
  { path: `dimensions.${of}.platform_mass`, label: `Platform mass ${of}`, unit: 'kg' },
  { path: `dimensions.${of}.stroke`, label: `Stroke ${of}`, ...MM },
];

const machine: Group = {
  title: 'Machine',
  fields: [
    { path: 'dimensions.l_m', label: 'Stack length', symbol: 'l_m', ...MM },
    { path: 'dimensions.N', label: 'Turns', symbol: 'N', whole: true },
    { path: 'dimensions.single_phase_force', label: 'Thrust, one phase', unit: 'N' },
    { path: 'dimensions.two_phase_force', label: 'Thrust, two phases', unit: 'N' },
    ...axis('x'),
    ...axis('y'),
  ],
};

export const GROUPS: Record<Direction, readonly Group[]> = {
  requirements: shared('requirements'),
  dimensions: [machine, ...shared('dimensions')],
};

export const fieldsOf = (direction: Direction): Field[] =>
  GROUPS[direction].flatMap(({ fields }) => fields);

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
