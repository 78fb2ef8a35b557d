export { default } from '../../frontend/node_modules/uplot/dist/uPlot.esm.js';
