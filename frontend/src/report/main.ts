/** The script of a report: gains that are dragged, and the run that the page simulates with them. */

import { hasSimd } from '../kernel/module';
import type { Result } from '../kernel/result';
import { Experiment } from './experiment';
import { LiveFigures } from './live-figures';
import { LivePlot } from './live-plot';
import { lanesOf, moduleOf } from './numbers';
import { Sliders } from './sliders';

const REPRODUCED = 'The recorded gains.';

async function begin(section: HTMLElement): Promise<void> {
  const status = one<HTMLElement>(section, '[role=status]');
  const tools = one<HTMLElement>(section, '.gains');
  if (!hasSimd() || typeof DecompressionStream === 'undefined') {
    throw new Error('this browser has no WebAssembly with SIMD, or cannot decompress');
  }
  const module = await moduleOf(one(section, '[data-kernel]').textContent ?? '');
  const lanes = await lanesOf(one(section, '[data-numbers]').textContent ?? '');
  const experiment = new Experiment(module, lanes);
  const { variants } = experiment;
  const plots = [...document.querySelectorAll<SVGSVGElement>('svg[data-samples]')].map(
    (svg) => new LivePlot(svg, variants),
  );
  const figures = new LiveFigures(document);
  const draw = () => {
    const started = performance.now();
    const result = experiment.run(sliders.values);
    for (const plot of plots) plot.draw(experiment);
    figures.show(result);
    status.textContent = textOf(result, performance.now() - started);
  };
  let frame = 0;
  const soon = () => {
    cancelAnimationFrame(frame);
    frame = requestAnimationFrame(draw);
  };
  const sliders = new Sliders(
    tools.querySelectorAll<HTMLElement>('[data-path]'),
    soon,
    (reason) => (status.textContent = reason),
  );
  one(section, 'button').addEventListener('click', () => {
    cancelAnimationFrame(frame);
    sliders.back();
    for (const plot of plots) plot.clear();
    figures.clear();
    status.textContent = REPRODUCED;
  });
  status.textContent = REPRODUCED;
  tools.hidden = false;
}

function textOf({ variants }: Result, milliseconds: number): string {
  const notes = Object.entries(variants).flatMap(([name, { diverged }]) =>
    diverged ? [`${name} diverges at ${diverged.time.toFixed(4)} s: ${diverged.channel}.`] : [],
  );
  return [`Computed by this page in ${milliseconds.toFixed(0)} ms.`, ...notes].join(' ');
}

function one<T extends Element>(parent: ParentNode, selector: string): T {
  const element = parent.querySelector<T>(selector);
  if (!element) throw new Error(`the report has no ${selector}`);
  return element;
}

const section = document.querySelector<HTMLElement>('#experiment');
if (section?.querySelector('[data-numbers]')) {
  begin(section).catch((error: unknown) => {
    const reason = error instanceof Error ? error.message : String(error);
    one<HTMLElement>(section, '[role=status]').textContent = `It cannot be simulated: ${reason}.`;
  });
}
