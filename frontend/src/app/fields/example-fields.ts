/** Some fields and metrics as the server tells them, known in every test. */

import type { FieldEntry, MetricEntry } from '../api/types';
import { served } from './fields.svelte';

const CHOICES: Readonly<Record<string, readonly string[]>> = {
  law: ['force-per-ampere', 'sine', 'cubic'],
  direction: ['ccw'],
};

type Example = readonly [label: string, unit?: string, factor?: number];

const FIELDS: Readonly<Record<string, Example>> = {
  'variants.*.controller.x.k_p': ['k_p x', 'N/mm', 1e-3],
  'variants.*.controller.y.k_p': ['k_p y', 'N/mm', 1e-3],
  'variants.*.controller.x.k_d': ['k_d x', 'N s/mm', 1e-3],
  'variants.*.controller.x.notch.gain': ['notch gain x'],
  'variants.*.controller.y.notch.gain': ['notch gain y'],
  'variants.*.controller.sharing.law': ['force sharing'],
  'variants.*.controller.model.x.friction.F_s': ['stiction F_s x', 'N'],
  'plant.x.friction.F_s': ['stiction F_s', 'N'],
  'plant.x.friction.v_s': ['speed v_s', 'mm/s', 1e3],
  'plant.x.encoder.resolution': ['encoder count', 'nm', 1e9],
  'plant.x.amplifiers.offset': ['amplifier offset', 'A'],
  'plant.x.mass': ['mass', 'kg'],
  plant: ['motor'],
  'trajectory.radius': ['radius', 'mm', 1e3],
  'trajectory.frequency': ['frequency', 'Hz'],
  'trajectory.direction': ['direction'],
  'trajectory.lead_in': ['lead-in', 's'],
  'load.x': ['load x', 'N'],
  seed: ['seed'],
};

type Metric = readonly [label: string, unit: string, less: boolean, scale?: string];

const METRICS: Readonly<Record<string, Metric>> = {
  max_abs_following_error: ['max |e_$|', 'm', true, 'following'],
  rms_following_error: ['RMS e_$', 'm', true, 'following'],
  settling_time: ['settling $', 's', true],
  max_current: ['peak i_$', 'A', false],
};

function field(path: string, [label, unit = '', factor = 1]: Example): FieldEntry {
  const choices = (CHOICES[path.split('.').at(-1) as string] ?? []).map((value) => {
    return { value, label: value.replaceAll('-', ' '), description: '', unit: '' };
  });
  return { label, unit, factor, whole: path === 'seed', description: '', choices };
}

function metric([label, unit, less, scale = '']: Metric): MetricEntry {
  const rest = { meaning: label, formula: '', rank: 'main', scale } as const;
  return { label, unit, lower_is_better: less, ...rest };
}

const entries = Object.entries(FIELDS).map(([path, each]) => {
  const more = path.endsWith('notch.gain') ? { default: 1, example: 0.1 } : {};
  const usual = path.endsWith('x.k_p') ? { usual: [1e4, 1e7] } : {};
  return [path, { ...field(path, each), ...more, ...usual }];
});
const metrics = Object.entries(METRICS).map(([name, each]) => [name, metric(each)]);
served.scenario = {
  fields: Object.fromEntries(entries) as Record<string, FieldEntry>,
  schedulable: ['plant', 'variants', 'load'],
  metrics: Object.fromEntries(metrics) as Record<string, MetricEntry>,
  contour: {
    max: metric(['contour max', 'm', true, 'following']),
    rms: metric(['contour RMS', 'm', true, 'following']),
  },
};

/** 0.5 to 150 mm/s, each as far from the next in ratio. */
const SPEEDS = Array.from({ length: 32 }, (_, k) =>
  Number((5e-4 * 300 ** (k / 31)).toPrecision(4)),
);

const LIMITS = { gain_margin: 2, phase_margin: 0.5236, Ms: null, saturated: 0, force: null };
const below = (path: string, table: object) =>
  Object.fromEntries(Object.entries(table).map(([name, value]) => [`${path}.${name}`, value]));
const TUNE: Readonly<Record<string, unknown>> = {
  variant: null,
  axis: 'both',
  objective: { rms: 1 },
  constraints: LIMITS,
  ...below('constraints', LIMITS),
  bounds: { k_p: [1e4, 3e7], k_d: [1e2, 1e5] },
  'bounds.k_p': [1e4, 3e7],
  'bounds.k_d': [1e2, 1e5],
  window: null,
  'window.start': null,
  'window.end': null,
  plants: [],
  also: null,
  starts: 4,
  evaluations: 200,
};
const RAMPS = { enabled: true, rates: [20, 50, 100], share: 0.5, places: 7 };
const RECORD = { variant: null, position: null, force: null, mass: null, bandwidth: null };
const IDENTIFY: Readonly<Record<string, unknown>> = {
  axis: 'both',
  speeds: SPEEDS,
  time_max: 20,
  pitches_max: null,
  presliding: RAMPS,
  ...below('presliding', RAMPS),
  variant: null,
  apply_to: null,
  run: null,
  record: RECORD,
  ...below('record', RECORD),
};
const NAMES: Readonly<Record<string, Example>> = {
  'bounds.k_p': ['range of k_p', 'N/mm', 1e-3],
  'bounds.k_d': ['range of k_d', 'N s/mm', 1e-3],
  'window.start': ['start', 's'],
  'window.end': ['end', 's'],
  constraints: ['limits'],
  speeds: ['speeds', 'mm/s', 1e3],
  time_max: ['time of each', 's'],
  'requirements.g': ['air gap', 'mm', 1e3],
  'new.length': ['length along x', 'mm', 1e3],
  'load.forces': ['each normal force', 'N'],
};
const request = (defaults: Readonly<Record<string, unknown>>) => {
  const known = Object.entries(defaults).map(([path, value]) => {
    return [path, { ...field(path, NAMES[path] ?? [path]), default: value }] as const;
  });
  return Object.fromEntries(known);
};
served.requests = {
  tune: request(TUNE),
  identify: request(IDENTIFY),
  design: request({ 'requirements.g': 0.3e-3, 'requirements.p': null }),
  platform: request({ 'new.length': 0.46, 'load.forces': [400, 400, 400, 400] }),
};
