/** Lengths of one phase's magnetic circuit, in the order of their form. */

import type { Group, Numbers } from '../quantity-fields';

const below = (names: readonly string[]) => names.map((name) => `geometry.${name}`);

export const GROUPS: readonly Group[] = [
  { title: 'Teeth', paths: below(['tau', 'p', 'g', 'n']) },
  { title: 'Stack and winding', paths: below(['l_m', 'N', 'i']) },
  {
    title: 'Cross-section (our reading)',
    paths: below([
      ...['tooth_depth', 'shoe', 'limb', 'yoke', 'window', 'coil'],
      ...['stator_tooth_depth', 'stator_back'],
    ]),
  },
  { title: 'Depth', paths: below(['stacking', 'post']) },
];

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
