// The whole plot core without its components: scopes, planes, curves, heat maps, tables.
export * from './plots-ours.js';
export { Plane } from '../../frontend/src/plot/plane.ts';
export { StillSource } from '../../frontend/src/plot/source.ts';
export { columnsOf } from '../../frontend/src/plot/table-columns.ts';
export * from '../../frontend/src/plot/curves.ts';
export * from '../../frontend/src/plot/heat-drawing.ts';
export * from '../../frontend/src/plot/heat-grid.ts';
export * from '../../frontend/src/plot/layout.ts';
export * from '../../frontend/src/plot/series-drawing.ts';
