// Six plots of 20,000 points that slide along, drawn by the page's own plot core and by uPlot.

import uPlot from '../../frontend/node_modules/uplot/dist/uPlot.esm.js';
import { Canvas } from '../../frontend/src/plot/canvas.ts';
import { ScopeChart } from '../../frontend/src/plot/scope-chart.ts';
import { Ring } from '../../frontend/src/app/stream/ring.ts';
import { LiveSource } from '../../frontend/src/screens/lab/scopes/live-source.ts';

const [PLOTS, POINTS, STEP, SHIFT] = [6, 20_000, 5e-4, 33];
const [WIDTH, HEIGHT] = [1000, 110];
const INKS = { grid: '#e9edf1', axis: '#59636e', strong: '#aeb7c0', a: '#d55e00' };

/** Two sines and noise, one sample a control period, as a following error looks. */
function samples(from, count, k) {
  const seeded = (i) => ((Math.imul(i + 7919 * k, 2654435761) >>> 0) / 2 ** 32 - 0.5) * 2e-7;
  return Float64Array.from({ length: count }, (_, i) => {
    const t = (from + i) * STEP;
    return 2e-5 * Math.sin(2 * t + k) + 2e-6 * Math.sin(60 * t) + seeded(from + i);
  });
}

function box() {
  const made = document.createElement('div');
  made.style.cssText = `width:${WIDTH}px;height:${HEIGHT}px`;
  document.body.append(made);
  return made;
}

function ours(frames) {
  const names = Array.from({ length: PLOTS }, (_, k) => `e${k}`);
  const ring = new Ring(60_000, names);
  const source = new LiveSource(() => ring, STEP);
  const news = names.map((_, k) => Float32Array.from(samples(0, POINTS + frames * SHIFT, k)));
  ring.write(0, news.map((values) => values.subarray(0, POINTS)));
  const charts = names.map((column) => {
    const element = document.createElement('canvas');
    element.style.cssText = `display:block;width:${WIDTH}px;height:${HEIGHT}px`;
    box().append(element);
    const canvas = new Canvas(element, INKS);
    canvas.resize(WIDTH, HEIGHT);
    const events = { point() {}, zoom() {}, reset() {}, set() {}, drag() {} };
    const trace = { column, label: column, ink: 'a' };
    return new ScopeChart(canvas, { unit: 'm', traces: [trace] }, events, true, true);
  });
  const still = { follow: true, moments: [], cursors: [], hover: null, selection: null };
  return (frame) => {
    const from = POINTS + frame * SHIFT;
    ring.write(from, news.map((values) => values.subarray(from, from + SHIFT)));
    const range = { from: (ring.end - POINTS) * STEP, to: ring.end * STEP };
    for (const chart of charts) chart.draw(source, { ...still, range, quantileBands: NONE });
  };
}
const NONE = [];

function theirs(frames) {
  const count = POINTS + frames * SHIFT;
  const times = Float64Array.from({ length: count }, (_, i) => i * STEP);
  const axis = { stroke: INKS.axis, grid: { stroke: INKS.grid, width: 1 }, font: '11px sans-serif' };
  const charts = Array.from({ length: PLOTS }, (_, k) => {
    const values = samples(0, count, k);
    const options = {
      width: WIDTH,
      height: HEIGHT,
      legend: { show: false },
      scales: { x: { time: false } },
      series: [{}, { stroke: INKS.a, width: 1.5, points: { show: false } }],
      axes: [{ ...axis, size: 22 }, { ...axis, size: 66, ticks: { show: false } }],
    };
    return { values, plot: new uPlot(options, [times.slice(0, 2), values.slice(0, 2)], box()) };
  });
  return (frame) => {
    const from = (frame + 1) * SHIFT;
    const x = times.subarray(from, from + POINTS);
    for (const { plot, values } of charts) plot.setData([x, values.subarray(from, from + POINTS)]);
  };
}

/** Draws frame after frame, each in its animation frame; returns ms of script of each. */
globalThis.measure = async (who, frames) => {
  document.body.replaceChildren();
  const draw = { ours, uPlot: theirs }[who](frames);
  const taken = [];
  for (let frame = 0; frame < frames; frame++) {
    await new Promise(requestAnimationFrame);
    const begin = performance.now();
    draw(frame);
    await null; // uPlot draws in a microtask
    taken.push(performance.now() - begin);
  }
  const inked = [...document.querySelectorAll('canvas')].filter((canvas) =>
    canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data.some(Boolean),
  );
  return { taken: taken.slice(frames / 4), plots: inked.length };
};
