/** What the Bode plots are given: the linearised loops, and what was measured. */

import type { PlantValue, LoopResponse, MeasuredLoop } from '../../app/api/types';
import type { Mark, Series } from '../../plot/types';
import { digits } from '../../ui/units';
import { inDecibels, inDegrees } from '../../parts/loop/margins';
import type { LookedAt } from './loop-store.svelte';

export const VIEWS = [
  { view: 'open', name: 'L', title: 'Open loop L = C P' },
  { view: 'closed', name: 'T', title: 'Closed loop T = L/(1 + L)' },
  { view: 'sensitivity', name: 'S', title: 'Sensitivity S = 1/(1 + L)' },
] as const;
export type LoopView = (typeof VIEWS)[number]['view'];

export interface Shown {
  present: LookedAt | null;
  chosen: LookedAt | null;
}

const LOWEST = 1; // Hz
const DEGREES = 180 / Math.PI;
const NORMAL = 1.96; // half of a 95 % interval, over the standard error

/** Frequencies below the plot are left out, so that its axis fits what is shown. */
function within({ frequency }: LoopResponse, values: readonly number[]): [number[], number[]] {
  const first = Math.max(
    0,
    frequency.findIndex((f) => f >= LOWEST),
  );
  return [frequency.slice(first), values.slice(first)];
}

function lines(shown: Shown, values: (response: LoopResponse) => readonly number[]): Series[] {
  const of = (looked: LookedAt | null, name: string, style: Partial<Series>): Series[] => {
    if (!looked) return [];
    const [x, y] = within(looked.response, values(looked.response));
    return [{ name, x, y, kind: 'line', ...style }];
  };
  return [
    ...of(shown.present, 'present', { ink: 'text' }),
    ...of(shown.chosen, 'chosen', { ink: 'staged', dash: 'dash' }),
  ];
}

export function curvesOf(shown: Shown, view: LoopView): Series[] {
  return lines(shown, (response) => response[view].magnitude);
}

export function phasesOf(shown: Shown): Series[] {
  return lines(shown, ({ open }) => open.phase.map((phase) => phase * DEGREES));
}

/**
 * A measured loop, with 95 % intervals where it is the open one, and the linearised loop at the
 * velocity of the slides.
 */
export function measuredSeries(
  measured: MeasuredLoop | null,
  view: LoopView,
  part: 'magnitude' | 'phase',
  of = '',
): Series[] {
  if (!measured) return [];
  const unit = part === 'phase' ? DEGREES : 1;
  const scaled = (loop: LoopResponse) => loop[view][part].map((value) => value * unit);
  const [x, y] = within(measured.linearised, scaled(measured.linearised));
  const speed = `${String(Number(digits(measured.velocity * 1e3)))} mm/s`;
  return [
    { name: `linear, ${speed}`, x, y, kind: 'line', ink: 'muted', dash: 'dot' },
    ...(measured.fitted
      ? [
          {
            name: `fitted${of}`,
            x: measured.fitted.loop.frequency,
            y: scaled(measured.fitted.loop),
            kind: 'line' as const,
            ink: 'good' as const,
          },
        ]
      : []),
    {
      name: `measured${of}, ${speed}`,
      x: measured.frequency,
      y: scaled(measured),
      ...(view === 'open' ? ends(measured, part) : {}),
      kind: 'points',
      marker: 'dot',
      ink: 'muted',
    },
  ];
}

/** Ends of the intervals of the open loop: those of the plant, since the controller is known. */
function ends({ open, plant }: MeasuredLoop, part: 'magnitude' | 'phase') {
  const end = (sign: number) =>
    open[part].map((value, k) => {
      const half = plant.interval[k] ?? 0;
      return part === 'phase'
        ? (value + sign * half) * DEGREES
        : value * Math.max(0, 1 + sign * half);
    });
  return { low: end(-1), high: end(1) };
}

const SIGNALS: Readonly<Record<string, string>> = {
  noise: 'by noise',
  chirp: 'by a chirp',
  'stepped-sine': 'by stepped sines',
};

/** The signal of a request, where it is not the usual one: `by noise`. */
export function signalText({ signal }: Readonly<Record<string, unknown>> = {}): string {
  return typeof signal === 'string' ? (SIGNALS[signal] ?? '') : '';
}

/** Margins of a measured loop as a sentence; `by` what it was measured. */
export function measuredText(
  { margins, velocity, seconds, crossings, half_force: half }: MeasuredLoop,
  by = '',
): string {
  // Before the last slide there are no intervals, and a margin that is not there may come.
  const whole = Object.values(margins).some(({ interval }) => interval !== null);
  const of = (
    name: string,
    title: string,
    unit: string,
    shown: (value: number | null) => string,
  ) => {
    const { value = null, interval = null } = margins[name] ?? {};
    if (value === null) return whole ? [`no ${title}`] : [];
    // What is shown of a gain that falls is the factor by which it may.
    const ends = interval && (name === 'gain_reduction' ? [...interval].reverse() : interval);
    const range = ends ? ` (${ends.map(shown).join(' to ')})` : '';
    return [`${title} ${shown(value)}${range} ${unit}`];
  };
  const margin = [
    ...of('crossover', 'crossover', 'Hz', (value) => digits(value ?? NaN)),
    ...of('phase_margin', 'phase margin', '°', inDegrees),
    ...of('gain_margin', 'gain margin', 'dB', inDecibels),
    ...(margins.gain_reduction?.value
      ? of('gain_reduction', 'and downwards', 'dB', (value) => inDecibels(1 / (value ?? NaN)))
      : []),
  ];
  const minute = `${digits(seconds)} s of sliding at ${digits(velocity * 1e3)} mm/s`;
  const all = crossings.map((at) => `${digits(at.frequency)} Hz (${inDegrees(at.phase_margin)}°)`);
  const several = all.length > 1 ? ` It crosses 1 at ${all.join(', ')}.` : '';
  const smaller = half
    ? ` With half the force the plant is ${half.gain.toFixed(3)} ± ${half.interval.toFixed(3)} times as large; the intervals hold both.`
    : '';
  const colon = margin.length > 0 ? `: ${margin.join(', ')}` : '';
  const intervals = whole ? ' In brackets 95 % intervals.' : '';
  return `Measured ${by === '' ? '' : `${by} `}in ${minute}${colon}.${intervals}${several}${smaller}`;
}

/** The model that was fitted to a measured plant, as a sentence; empty where there is none. */
export function fittedText({ fitted }: MeasuredLoop): string {
  if (!fitted) return '';
  const of = (name: string, value: PlantValue | null | undefined, unit: string, factor = 1) => {
    if (!value) return [];
    const half = NORMAL * value.error * factor;
    // Two figures of the interval, and no more of the value.
    const places = half > 0 ? Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(half)))) : 6;
    const size = (value.value * factor).toFixed(places).replace('-', '−');
    return [`${name} ${size} ± ${half.toFixed(places)} ${unit}`.trim()];
  };
  const parts = [
    ...of('mass', fitted.mass, 'kg'),
    ...of('delay', fitted.delay, 'ms', 1e3),
    ...of('lag', fitted.lag, 'ms', 1e3),
    ...of('damping', fitted.damping, 'N s/m'),
    ...of('stiffness', fitted.stiffness, 'N/mm', 1e-3),
    ...fitted.modes.flatMap(({ frequency, damping }) => [
      ...of('mode at', frequency, 'Hz'),
      ...of('its damping', damping, ''),
    ]),
  ];
  return `Fitted: ${parts.join(', ')}; misfit ${digits(fitted.misfit)} (1: intervals explain it).`;
}

/** Frequency, of those where `values` crosses `level`, at which `distance` is least. */
function crossing(
  { frequency }: LoopResponse,
  values: readonly number[],
  level: number,
  distance: (share: number, k: number) => number,
): number | null {
  let [crossover, least] = [null as number | null, Infinity];
  for (let k = 1; k < frequency.length; k++) {
    const [a, b] = [(values[k - 1] ?? NaN) - level, (values[k] ?? NaN) - level];
    if (!(a * b <= 0) || a === b) continue;
    const share = a / (a - b);
    const away = distance(share, k);
    if (away >= least) continue;
    const [from, to] = [frequency[k - 1] ?? NaN, frequency[k] ?? NaN];
    [crossover, least] = [from * (to / from) ** share, away];
  }
  return crossover;
}

function between(values: readonly number[], share: number, k: number): number {
  const [a, b] = [values[k - 1] ?? NaN, values[k] ?? NaN];
  return a + share * (b - a);
}

/** The gain margin in the magnitude of L: from L to one, where its phase is −180°. */
export function gainMarginMark(looked: LookedAt | null): Mark[] {
  const margin = looked?.figures?.gain_margin;
  if (!looked || typeof margin !== 'number') return [];
  const { magnitude, phase } = looked.response.open;
  const at = crossing(looked.response, phase, -Math.PI, (share, k) =>
    Math.abs(Math.log(between(magnitude, share, k) * margin)),
  );
  if (at === null) return [];
  const label = `gain margin ${inDecibels(margin)} dB`;
  return [{ axis: 'x', at, between: [1 / margin, 1], label, ink: 'good' }];
}

/** The phase margin in the phase of L: from −180° to L, where its magnitude is one. */
export function phaseMarginMark(looked: LookedAt | null): Mark[] {
  const margin = looked?.figures?.phase_margin;
  if (!looked || typeof margin !== 'number') return [];
  const { magnitude, phase } = looked.response.open;
  const away = (at: number) => Math.abs(Math.abs(at + Math.PI) - margin);
  const logs = magnitude.map(Math.log);
  const at = crossing(looked.response, logs, 0, (share, k) => away(between(phase, share, k)));
  if (at === null) return [];
  const k = looked.response.frequency.findIndex((f) => f >= at);
  const side = (phase[k] ?? 0) < -Math.PI ? -1 : 1;
  const label = `phase margin ${inDegrees(margin)}°`;
  const end = -180 + side * margin * DEGREES;
  return [{ axis: 'x', at, between: [-180, end], label, ink: 'good' }];
}

/** Crossover and gain one of L, bandwidth of T, peak of S. */
export function marksOf(looked: LookedAt | null, view: LoopView): Mark[] {
  const figures = looked?.figures;
  if (!figures) return [];
  const marks: Mark[] = [];
  if (view === 'open') {
    marks.push({ axis: 'y', at: 1, label: '1', ink: 'muted', dash: 'dash' });
    if (figures.crossover !== null) {
      marks.push({
        axis: 'x',
        at: figures.crossover,
        label: 'crossover',
        ink: 'muted',
        dash: 'dot',
      });
    }
    marks.push(...gainMarginMark(looked));
  } else if (view === 'closed' && figures.bandwidth !== null) {
    marks.push({ axis: 'x', at: figures.bandwidth, label: 'bandwidth', ink: 'muted', dash: 'dot' });
  } else if (view === 'sensitivity') {
    marks.push({ axis: 'y', at: figures.Ms, label: 'Ms', ink: 'muted', dash: 'dash' });
  }
  return marks;
}
