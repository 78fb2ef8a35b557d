/** The tabs of the Motor screen. */

import type { Component } from 'svelte';

export interface Tab {
  value: string;
  name: string;
  title: string;
  load: () => Promise<{ default: Component }>;
}

export const TABS: readonly [Tab, ...Tab[]] = [
  {
    value: 'sizing',
    name: 'Sizing',
    title: 'Equations (1) to (14), from requirements to dimensions and back',
    load: () => import('./sizing/Sizing.svelte'),
  },
  {
    value: 'maps',
    name: 'Force maps',
    title: 'Thrust and normal force of one phase by finite elements',
    load: () => import('./maps/Maps.svelte'),
  },
  {
    value: 'sharing',
    name: 'Force sharing',
    title: 'One force shared among the phases over a pole pitch, law beside law',
    load: () => import('./sharing/Sharing.svelte'),
  },
  {
    value: 'platform',
    name: 'Platform',
    title: 'Bending of the moving platforms under the normal forces, and the air gap',
    load: () => import('./platform/Platform.svelte'),
  },
];

/** The tab of a name in the address, else the first. */
export function tabOf(name: string | null): Tab {
  return TABS.find(({ value }) => value === name) ?? TABS[0];
}
