/** The views of the page: one for each of the server, loaded when it is shown. */

import type { Component } from 'svelte';
import type { Subject, ViewName } from './views-api';

type View = () => Promise<{
  default: Component<{ subject: Subject; names: readonly string[] }>;
}>;

export const VIEWS: Readonly<Record<ViewName, View>> = {
  ballbar: () => import('./BallbarView.svelte'),
  contouring: () => import('./ContouringView.svelte'),
  cost: () => import('./CostView.svelte'),
  friction: () => import('./FrictionView.svelte'),
  positioning: () => import('./PositioningView.svelte'),
};
