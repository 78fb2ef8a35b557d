/** The script of a report: gains that are dragged, and the run that the page simulates with them. */

import { hasSimd } from '../kernel/module';
import type { Result } from '../kernel/result';
import type { Inputs } from '../kernel/tasks';
import { Experiment } from './experiment';
import { LiveFigures } from './live-figures';
import { LivePlane } from './live-plane';
import { LivePlot } from './live-plot';
import { moduleOf, recordOf } from './numbers';
import { Sliders } from './sliders';

const RECORDED = 'The recorded gains.';
const CHAOTIC =
  'With them this page computes other errors than were recorded: the loop amplifies rounding.';

async function begin(section: HTMLElement): Promise<void> {
  const status = one<HTMLElement>(section, '[role=status]');
  const tools = one<HTMLElement>(section, '.gains');
  if (!hasSimd() || typeof DecompressionStream === 'undefined') {
    throw new Error('this browser has no WebAssembly with SIMD, or cannot decompress');
  }
  const module = await moduleOf(one(section, '[data-kernel]').textContent ?? '');
  const experiments = await experimentsOf(section, module);
  const plots = pictures('data-grid', (svg) => new LivePlot(svg, experiments));
  const own = experiments.get(''); // of a report of one run
  const planes = own ? pictures('data-plane', (svg) => new LivePlane(svg, own)) : [];
  const figures = new LiveFigures(document);
  const run = () =>
    [...experiments].flatMap(([number, experiment]) => {
      const result = experiment.run(sliders.valuesOf(number));
      figures.show(number, result);
      return notesOf(number, result);
    });
  const draw = () => {
    const started = performance.now();
    const notes = run();
    for (const picture of [...planes, ...plots]) picture.draw();
    const took = (performance.now() - started).toFixed(0);
    status.textContent = [`Computed by this page in ${took} ms.`, ...notes].join(' ');
  };
  let frame = 0;
  const soon = () => {
    cancelAnimationFrame(frame);
    frame = requestAnimationFrame(draw);
  };
  const refused = (reason: string) => (status.textContent = reason);
  const sliders = new Sliders(tools, soon, refused);
  one(section, 'button').addEventListener('click', () => {
    cancelAnimationFrame(frame);
    sliders.back();
    for (const picture of [...planes, ...plots]) picture.clear();
    figures.clear();
    status.textContent = recorded;
  });
  run();
  const recorded = figures.agrees ? RECORDED : `${RECORDED} ${CHAOTIC}`;
  figures.clear();
  status.textContent = recorded;
  tools.hidden = false;
}

function pictures<T>(attribute: string, of: (svg: SVGSVGElement) => T): T[] {
  return [...document.querySelectorAll<SVGSVGElement>(`svg[${attribute}]`)].map(of);
}

/** Runs of the report by their number, of a single one empty. */
async function experimentsOf(
  section: HTMLElement,
  module: WebAssembly.Module,
): Promise<Map<string, Experiment>> {
  const experiments = new Map<string, Experiment>();
  let before: Inputs | null = null;
  for (const block of section.querySelectorAll<HTMLElement>('[data-numbers]')) {
    const { lanes, inputs } = await recordOf(block.textContent ?? '', before);
    experiments.set((block.dataset.numbers ?? '').trim(), new Experiment(module, lanes, inputs));
    before = inputs;
  }
  return experiments;
}

function notesOf(run: string, { variants }: Result): string[] {
  return Object.entries(variants).flatMap(([name, { diverged }]) =>
    diverged
      ? [`${run} ${name} diverges at ${diverged.time.toFixed(4)} s: ${diverged.channel}.`]
      : [],
  );
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
