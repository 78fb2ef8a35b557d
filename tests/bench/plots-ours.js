// What draws the scopes, as a bundle of its own: its size is compared with uPlot's.
export { Canvas } from '../../frontend/src/plot/canvas.ts';
export { readPalette } from '../../frontend/src/plot/palette.ts';
export { ScopeChart } from '../../frontend/src/plot/scope-chart.ts';
