/** The views of the page: one for each of the server, loaded when it is shown. */

import type { Component } from 'svelte';
import type { Subject, ViewName } from './views-api';

export interface View {
  name: string;
  title: string;
  load: () => Promise<{ default: Component<{ subject: Subject; names: readonly string[] }> }>;
}

export const VIEWS: Readonly<Record<ViewName, View>> = {
  ballbar: {
    name: 'Ballbar',
    title: 'Radial deviation on a circle, both directions',
    load: () => import('./BallbarView.svelte'),
  },
  contouring: {
    name: 'Contouring',
    title: 'Distance from the path beside the following error',
    load: () => import('./ContouringView.svelte'),
  },
  cost: {
    name: 'Cost',
    title: 'Energy, currents and forces, B beside A',
    load: () => import('./CostView.svelte'),
  },
  friction: {
    name: 'Friction',
    title: 'True, estimated and compensated friction',
    load: () => import('./FrictionView.svelte'),
  },
  positioning: {
    name: 'Positioning',
    title: 'Accuracy and repeatability at targets, ISO 230-2 style',
    load: () => import('./PositioningView.svelte'),
  },
};
