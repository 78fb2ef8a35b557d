/** Which view is shown, of what, and of which channels: as an address has it and as a browser keeps it. */

import type { Range } from '../../plot/range';
import { load, save } from '../../app/storage';
import type { ViewName } from './views-api';

export type ViewKind = 'spectrum' | 'xy' | 'own' | ViewName;

export interface ViewChoice {
  kind: ViewKind;
  /** `lab` is what the Lab shows, `staged` its what-if, `live` its session; else a run's id. */
  of: string;
  /**
   * Of a spectrum; of XY pairs of x and y, one after the other; of a view of one's own its name.
   * Empty for those that suggest themselves.
   */
  channels: readonly string[];
  /** s; null for the stretch that metrics are of, or the newest samples. */
  stretch: Range | null;
}

export interface KindEntry {
  name: string;
  title: string;
  /** Other words by which it is found. */
  also: string;
}

/** Every kind of view, in the order of the menu. */
export const KINDS: Readonly<Record<ViewKind, KindEntry>> = {
  spectrum: {
    name: 'Spectrum',
    title: 'Spectral density and peaks of any channels',
    also: 'fft psd fourier frequency power spectral density harmonics noise resonance vibration',
  },
  xy: {
    name: 'XY',
    title: 'Any channel over another',
    also: 'x-y xy plot lissajous phase portrait orbit scatter hysteresis loop over channel',
  },
  ballbar: {
    name: 'Ballbar',
    title: 'Radial deviation on a circle, both directions',
    also: 'circularity roundness circular test iso 230-4 quadrant glitch squareness backlash polar',
  },
  contouring: {
    name: 'Contouring',
    title: 'Distance from the path beside the following error',
    also: 'contour error tracking error path deviation lag corner',
  },
  friction: {
    name: 'Friction',
    title: 'True, estimated and compensated friction',
    also: 'stribeck lugre bristle presliding breakaway stiction hysteresis',
  },
  positioning: {
    name: 'Positioning',
    title: 'Accuracy and repeatability at targets, ISO 230-2 style',
    also: 'accuracy repeatability iso 230-2 reversal value laser interferometer targets',
  },
  cost: {
    name: 'Cost',
    title: 'Energy, currents and forces, B beside A',
    also: 'energy power copper loss heat effort current rms thrust efficiency',
  },
  own: {
    name: 'Own',
    title: 'A view of one’s own, of a file of the server',
    also: 'plugin own view',
  },
};

const isKind = (kind: string): kind is ViewKind => Object.hasOwn(KINDS, kind);

/** Parameters of an address that hold the panes of the page of views. */
export const PANES = ['pane', 'pane2'] as const;

/** Writes a choice: kind, of what, the stretch where there is one, channels, parted by spaces. */
export function writeChoice({ kind, of, channels, stretch }: ViewChoice): string {
  const part = stretch ? [`${figures(stretch.from)}..${figures(stretch.to)}`] : [];
  return [kind, of, ...part, ...channels.map(escaped)].join(' ');
}

/** Reads a choice; null of a text that is none. */
export function readChoice(text: string | null): ViewChoice | null {
  const [kind = '', of = '', ...rest] = (text ?? '').split(' ').filter(Boolean);
  if (!isKind(kind) || !/^[\w-]+$/.test(of)) return null;
  const [, from, to] = /^(-?[\d.]+(?:e-?\d+)?)\.\.(-?[\d.]+(?:e-?\d+)?)$/.exec(rest[0] ?? '') ?? [];
  const stretch = { from: Number(from), to: Number(to) };
  const there = from !== undefined;
  return {
    kind,
    of,
    channels: (there ? rest.slice(1) : rest).slice(0, CHANNELS_MAX).map(unescaped),
    stretch: there && stretch.to > stretch.from ? stretch : null,
  };
}

/** Most channels of a spectrum, as the server takes them, and numbers of an XY plot's pairs. */
export const CHANNELS_MAX = 8;

/** The choice that a browser has kept under a name, else the first. */
export function keptChoice(key: string, first: ViewChoice): ViewChoice {
  const kept = readChoice(load(key, ''));
  return kept ? { ...kept, of: first.of, stretch: first.stretch } : first;
}

export function keepChoice(key: string, choice: ViewChoice): void {
  save(key, writeChoice({ ...choice, stretch: null }));
}

/** Returns the choice of another source: with its channels, if it may have them. */
export const ofSource = (choice: ViewChoice, of: string): ViewChoice => ({
  ...choice,
  of,
  stretch: null,
});

/** Returns the choice of another kind: its channels are others. */
export const ofKind = (choice: ViewChoice, kind: ViewKind): ViewChoice =>
  kind === choice.kind ? choice : { ...choice, kind, channels: [] };

const figures = (time: number) => String(Number(time.toPrecision(9)));
const escaped = (name: string) => name.replace(/[%\s]/g, encodeURIComponent);
function unescaped(name: string): string {
  try {
    return decodeURIComponent(name);
  } catch {
    return name; // written by hand
  }
}
