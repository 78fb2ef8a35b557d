/** Lengths of one phase's magnetic circuit, in the order of their form. Ranges are the server's. */

import type { Field, Numbers } from '../quantity-fields';

const MM = { factor: 1e3, unit: 'mm' };

export interface Group {
  title: string;
  fields: Field[];
}

export const GROUPS: readonly Group[] = [
  {
    title: 'Teeth',
    fields: [
      { path: 'tau', label: 'Pole pitch', symbol: 'tau', ...MM },
      { path: 'p', label: 'Tooth', symbol: 'p', ...MM },
      { path: 'g', label: 'Air gap', symbol: 'g', ...MM },
      { path: 'n', label: 'Teeth per limb', symbol: 'n', whole: true },
    ],
  },
  {
    title: 'Stack and winding',
    fields: [
      { path: 'l_m', label: 'Stack length', symbol: 'l_m', ...MM },
      { path: 'N', label: 'Turns', symbol: 'N', whole: true },
      { path: 'i', label: 'Largest current', symbol: 'i', unit: 'A' },
    ],
  },
  {
    title: 'Cross-section (our reading)',
    fields: [
      { path: 'tooth_depth', label: 'Tooth depth', ...MM },
      { path: 'shoe', label: 'Shoe height', ...MM },
      { path: 'limb', label: 'Limb width', ...MM },
      { path: 'yoke', label: 'Yoke height', ...MM },
      { path: 'window', label: 'Window height', ...MM },
      { path: 'coil', label: 'Coil width', ...MM },
      { path: 'stator_tooth_depth', label: 'Stator teeth, depth', ...MM },
      { path: 'stator_back', label: 'Stator back', ...MM },
    ],
  },
  {
    title: 'Depth',
    fields: [
      { path: 'stacking', label: 'Iron in the stack' },
      { path: 'post', label: 'Stator posts’ share' },
    ],
  },
];

export const FIELDS: readonly Field[] = GROUPS.flatMap(({ fields }) => fields);

export interface Design {
  value: string;
  name: string;
  title: string;
  geometry: Numbers;
}

/** Of the previous design the paper gives tau and n; its coils fit the window that follows. */
export const DESIGNS: readonly [Design, ...Design[]] = [
  {
    value: 'paper',
    name: 'Paper',
    title: "The paper's motor, with our cross-section",
    geometry: {},
  },
  {
    value: 'previous',
    name: 'Previous',
    title: 'The motor before: τ = 9 mm, n = 2; teeth as wide as slots, all else as now',
    geometry: { tau: 9e-3, p: 4.5e-3, n: 2, coil: 6.5e-3 },
  },
];

export type Accuracy = 'preview' | 'default' | 'reference';
export const ACCURACIES = [
  { value: 'preview', name: 'Preview', title: 'Magnetic circuit, at once; Compute keeps it' },
  { value: 'default', name: 'Default', title: '24 cells a pitch, about a minute' },
  { value: 'reference', name: 'Reference', title: '48 cells a pitch, some minutes' },
] as const;

/** What differs from the defaults. */
export function changesFrom(
  geometry: Readonly<Record<string, number>>,
  defaults: Readonly<Record<string, number>>,
): Numbers {
  return Object.fromEntries(
    Object.entries(geometry).filter(([key, value]) => defaults[key] !== value),
  );
}
