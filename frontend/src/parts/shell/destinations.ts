/** What is found besides what the present screen shows: views, the contents of screens, scenarios, runs. */

import { SCREENS, screen, type Screen } from '../../app/screen.svelte';
import { app } from '../../app/store.svelte';
import { focusPart } from '../../ui/focus';
import { listRuns } from '../runs/runs-api';
import { KINDS, PANES, writeChoice, type ViewKind } from '../views/view-choice';
import type { Command } from './commands';

/** So long a part of a screen is waited for, ms. */
const PATIENCE = 10_000;
/** Most runs that are listed, and the shortest words that they are looked for by. */
const RUNS = 8;
const SHORTEST = 2;

export interface Content {
  screen: Screen;
  /** As it is labelled on its screen. */
  part: string;
  name: string;
  also?: string;
}

/** What screens have, and other words for it. */
export const CONTENTS: readonly Content[] = [
  {
    screen: 'tune',
    part: 'Loop over frequency',
    name: 'Bode plot',
    also: 'loop over frequency response gain phase crossover nyquist open loop bandwidth',
  },
  {
    screen: 'tune',
    part: 'Loop figures',
    name: 'Phase margin, gain margin, M_s',
    also: 'margins stability sensitivity peak crossover bandwidth loop figures',
  },
  {
    screen: 'tune',
    part: 'Landscape',
    name: 'Gain landscape',
    also: 'map stability boundary k_p k_d',
  },
  {
    screen: 'tune',
    part: 'Search',
    name: 'Search of gains',
    also: 'optimise nelder-mead autotune tuning',
  },
  { screen: 'tune', part: 'Candidates', name: 'Candidates of a search' },
  { screen: 'tune', part: 'Limits', name: 'Limits of margins', also: 'constraints stability' },
  {
    screen: 'runs',
    part: 'Runs',
    name: 'Export of a run',
    also: 'export download csv parquet mat mcap mdf matlab telemetry data save',
  },
  {
    screen: 'runs',
    part: 'Runs',
    name: 'Import of a measurement',
    also: 'import csv upload measured',
  },
  {
    screen: 'runs',
    part: 'Runs',
    name: 'Comparison of two runs',
    also: 'compare difference tolerance regression',
  },
  {
    screen: 'lab',
    part: 'Scenario',
    name: 'Export of the session',
    also: 'export download csv parquet toml telemetry data save',
  },
  { screen: 'lab', part: 'Scopes', name: 'Scopes', also: 'oscilloscope curves channels time plot' },
  {
    screen: 'lab',
    part: 'Controllers',
    name: 'Controllers',
    also: 'gains k_p k_d pid law compensation feedforward notch',
  },
  {
    screen: 'lab',
    part: 'Plant',
    name: 'Plant',
    also: 'motor mass imperfections encoder stiction',
  },
  { screen: 'lab', part: 'Metrics', name: 'Metrics', also: 'max rms itae settling results' },
  {
    screen: 'lab',
    part: 'Monte Carlo',
    name: 'Monte Carlo',
    also: 'robustness tolerance uncertainty spread',
  },
  {
    screen: 'lab',
    part: 'Learning',
    name: 'Learning',
    also: 'ilc iterative learning control learn learnt force lap to lap repetitive',
  },
  {
    screen: 'trajectories',
    part: 'Path on the plane',
    name: 'Path editor',
    also: 'draw polygon spline g-code svg',
  },
  {
    screen: 'trajectories',
    part: 'Motion profile',
    name: 'Motion profile',
    also: 'velocity acceleration jerk limited trapezoid minimum',
  },
  { screen: 'trajectories', part: 'Saved paths', name: 'Saved paths' },
  {
    screen: 'identify',
    part: 'Measured',
    name: 'Stribeck curve',
    also: 'friction identification measured velocity',
  },
  { screen: 'identify', part: 'Residuals', name: 'Residuals of the friction fit' },
  { screen: 'sweep', part: 'Result', name: 'Sweep of fields', also: 'grid parameter study doe' },
  {
    screen: 'motor',
    part: 'Results',
    name: 'Motor sizing',
    also: 'design equations thrust turns airgap',
  },
  {
    screen: 'paper',
    part: 'Run',
    name: 'Tables and figures of the paper',
    also: 'published reproduction errata',
  },
  {
    screen: 'drive',
    part: 'State',
    name: 'State of the drives',
    also: 'ethercat arm torque fault status word link',
  },
];

function goTo({ screen: name, part }: Content): void {
  screen.go(name);
  const end = performance.now() + PATIENCE;
  const seek = (): void => {
    const place = document.querySelector<HTMLElement>(`main [aria-label="${part}"]`);
    if (place) {
      place.scrollIntoView({ block: 'nearest' });
      focusPart(place);
    } else if (screen.current === name && performance.now() < end) requestAnimationFrame(seek);
  };
  seek();
}

const titleOf = (name: Screen) => SCREENS.find((one) => one.screen === name)?.title ?? '';

/** Opens a view of what the Lab shows, over the whole page. */
function openView(kind: ViewKind): void {
  const of = app.mode === 'live' ? 'live' : 'staged';
  const pane = writeChoice({ kind, of, channels: [], stretch: null });
  screen.go('views', { [PANES[0]]: pane, [PANES[1]]: '' });
}

/** Everything that leads elsewhere, but for runs; `there` are the screens that there are. */
export function destinations(there: readonly Screen[]): Command[] {
  const fixed = Object.entries(KINDS).filter(([kind]) => kind !== 'own');
  const views = fixed.map(([kind, { name, title, also }]) => ({
    name: `${name}: ${title.charAt(0).toLowerCase()}${title.slice(1)}`,
    place: 'view',
    key: '',
    about: also,
    run: () => openView(kind as ViewKind),
  }));
  const contents = CONTENTS.filter((one) => there.includes(one.screen)).map((one) => ({
    name: one.name,
    place: titleOf(one.screen),
    key: '',
    about: `${one.part} ${one.also ?? ''}`,
    run: () => goTo(one),
  }));
  const scenarios = app.catalogue.scenarios.map(({ name, description }) => ({
    name,
    place: 'scenario',
    key: '',
    about: description,
    run: () => {
      screen.go('lab');
      void app.loadScenario(name);
    },
  }));
  return [...(there.includes('views') ? views : []), ...contents, ...scenarios];
}

/** Runs that the server finds by words; none where it does not understand them. */
export async function runsOf(typed: string): Promise<Command[]> {
  const q = typed.trim();
  if (q.length < SHORTEST) return [];
  try {
    const { runs } = await listRuns({ q, sort: '-created', limit: RUNS });
    return runs.map(({ id, name }) => ({
      name,
      place: `run ${id}`,
      key: '',
      about: q,
      run: () => screen.go('runs', { run: id }),
    }));
  } catch {
    return []; // no search, such as `B.x<`
  }
}
