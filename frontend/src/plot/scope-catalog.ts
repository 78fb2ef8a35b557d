/** What a scope shows of its channels: title, labels, colours and lines; and the layouts that ship. */

import { isMath, mathLabel } from './math-column';
import { type Channel, differenceOf } from './source';
import { type ScopeSpec, scopeWith } from './scope-layout';
import type { Trace, Traces } from './scope-chart';
import type { Dash, Look } from './types';
import { looksOf } from './palette';

type Axis = 'x' | 'y';

export interface Scope extends Traces {
  title: string;
  /** Its place in the layout. */
  place: number;
  spec: ScopeSpec;
  /** All its traces, also the hidden ones; `traces` has those that are drawn. */
  all: readonly ScopeTrace[];
}

export interface ScopeTrace extends Trace {
  unit: string;
  hidden: boolean;
}

interface Parts {
  column: string;
  /** `A`, `A-B`, or nothing of what all variants share. */
  variant: string;
  axis: string;
  /** `position` of `position_reference` too. */
  quantity: string;
  reference: boolean;
}

/** Span of an error's value axis while all is zero, m. */
const STILL = 1e-5;
const DASHES: readonly Dash[] = ['solid', 'dash', 'dot', 'dashdot', 'long'];

const PHASES: Readonly<Record<string, Look>> = {
  a: { ink: 'phase-a' },
  b: { ink: 'phase-b', dash: 'dash' },
  c: { ink: 'phase-c', dash: 'dot' },
};

/** Curves of one variant: several quantities, told apart by colour and line. */
const QUANTITIES: readonly Look[] = [
  { ink: 'reference' },
  { ink: 'phase-b', width: 2 },
  { ink: 'phase-a', dash: 'dash' },
  { ink: 'phase-c', dash: 'dot' },
  { ink: 'difference', dash: 'dashdot' },
  { ink: 'text', dash: 'long' },
];

function partsOf(column: string): Parts {
  if (isMath(column)) {
    return { column, variant: '', axis: '', quantity: mathLabel(column), reference: false };
  }
  const [, variant = '', axis = '', name = column] =
    /^(?:([A-Z](?:-[A-Z])?)\.)?(?:([xy])\.)?(.+)$/.exec(column) ?? [];
  const reference = name.endsWith('_reference');
  const quantity = reference ? name.slice(0, -'_reference'.length) : name;
  return { column, variant, axis, quantity, reference };
}

function only(values: readonly string[]): string | null {
  const [first] = values;
  return first !== undefined && values.every((value) => value === first) ? first : null;
}

const PHASE = /^current(_command)?_([abc])$/;

/** A quantity in words: `following error`, `phase a`. */
function words(quantity: string): string {
  const [, command, phase] = PHASE.exec(quantity) ?? [];
  if (phase !== undefined) return command ? `${phase} command` : phase;
  return quantity.replace(/^pd_/, 'PD_').replaceAll('_', ' ');
}

function capital(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1);
}

function titleOf(parts: readonly Parts[]): string {
  if (parts.every(({ column }) => isMath(column))) {
    const [first = '', second, more] = parts.map((each) => each.quantity);
    return `${first}${second === undefined ? '' : `, ${second}`}${more === undefined ? '' : ', …'}`;
  }
  const axis = only(parts.map((each) => each.axis)) ?? '';
  const quantity = only(parts.map((each) => each.quantity));
  if (quantity !== null) return capital(`${words(quantity)} ${axis}`.trim());
  const variant = only(parts.map((each) => each.variant)) ?? '';
  const whose = [variant, axis].filter(Boolean).join(' ');
  const phases = parts.every((each) => PHASE.test(each.quantity));
  const names = [...new Set(parts.map((each) => words(each.quantity)))];
  const what = phases ? 'phase currents' : names.slice(0, 2).join(', ');
  return capital(`${what}${names.length > 2 && !phases ? ', …' : ''} ${whose}`.trim());
}

function labelOf(part: Parts, parts: readonly Parts[]): string {
  const { variant, axis, quantity, reference, column } = part;
  if (isMath(column)) return quantity;
  const label: string[] = [];
  if (only(parts.map((each) => each.quantity)) === null) label.push(words(quantity));
  if (reference) label.push('reference');
  const variants = parts.filter((each) => !each.reference).map((each) => each.variant);
  if (variant && (only(variants) === null || label.length === 0)) {
    label.push(variant.replace('-', '−'));
  }
  if (axis && only(parts.map((each) => each.axis)) === null) label.push(axis);
  return label.join(' ') || words(quantity);
}

/** The look of each channel of a scope, hidden or not, so that hiding one changes no other. */
function lookOf(part: Parts, parts: readonly Parts[]): Look {
  const { variant, quantity, reference, axis } = part;
  if (isMath(part.column)) {
    // After those of the others, which keep theirs as math channels come and go.
    const math = parts.filter(({ column }) => isMath(column)).map(({ column }) => column);
    const others = parts.length - math.length;
    return QUANTITIES[(others + math.indexOf(part.column)) % QUANTITIES.length] as Look;
  }
  if (variant.includes('-')) return { ink: 'difference', dash: 'dash' };
  const letters = [...new Set(parts.filter(({ variant: of }) => of !== '').map((p) => p.variant))];
  const others = parts.filter((each) => each.variant === variant && !each.reference);
  const axes = [...new Set(parts.map((each) => each.axis))];
  const place = axes.length > 1 ? axes.indexOf(axis) : 0;
  if (reference) {
    return { ink: 'reference', width: 2.5, ...(place > 0 ? { dash: DASHES[place] } : {}) } as Look;
  }
  const phase = PHASE.exec(quantity)?.[2];
  if (phase !== undefined && letters.length < 2) return PHASES[phase] as Look;
  const quantities = [...new Set(others.map((each) => each.quantity))];
  const several = quantities.length > 1 && letters.length < 2;
  if (several || variant === '') {
    const all = [...new Set(others.map((each) => each.column))];
    return QUANTITIES[all.indexOf(part.column) % QUANTITIES.length] as Look;
  }
  const turn = Math.max(place, quantities.indexOf(quantity));
  const dash = DASHES[turn % DASHES.length] as Dash;
  return { ...looksOf(variant), ...(turn > 0 ? { dash } : {}) };
}

/** Returns what a scope draws; channels of unknown unit have none. */
export function scopeOf(spec: ScopeSpec, units: ReadonlyMap<string, string>, place = 0): Scope {
  const parts = spec.channels.map(partsOf);
  // Math channels have names of their own, which say nothing of the others.
  const recorded = parts.filter(({ column }) => !isMath(column));
  const named = recorded.length > 0 ? recorded : parts;
  const all = parts.map((part): ScopeTrace => {
    const { column } = part;
    const source = differenceOf(column)?.minuend ?? column;
    return {
      column,
      label: labelOf(part, named),
      unit: units.get(source) ?? '1',
      hidden: spec.hidden.includes(column),
      ...(spec.own.includes(column) ? { own: true } : {}),
      ...lookOf(part, parts),
    };
  });
  const errors = parts.every(({ quantity }) => quantity === 'following_error');
  return {
    title: titleOf(named),
    place,
    spec,
    unit: all[0]?.unit ?? '1',
    all,
    traces: all.filter(({ hidden }) => !hidden),
    ...(errors ? { still: STILL, spread: true } : {}),
  };
}

/** Units of channels by their name. */
export function unitsOf(channels: readonly Channel[]): ReadonlyMap<string, string> {
  return new Map(channels.map(({ name, unit }) => [name, unit]));
}

/** A channel in words: `Following error x of A`. */
export function channelName(column: string): string {
  if (isMath(column)) return mathLabel(column);
  const { variant, axis, quantity, reference } = partsOf(column);
  const what = `${words(quantity)}${reference ? ' reference' : ''} ${axis}`.trim();
  const phase = PHASE.test(quantity) ? 'current ' : '';
  return capital(`${phase}${what}${variant ? ` of ${variant.replace('-', '−')}` : ''}`);
}

/** Columns that the plane needs. */
function planeColumns(variants: readonly string[]): string[] {
  return [
    'x.position_reference',
    'y.position_reference',
    ...variants
      .slice(0, 2)
      .flatMap((variant) => [`${variant}.x.following_error`, `${variant}.y.following_error`]),
  ];
}

/** Columns to read: those of the plane and of these scopes, each once. */
export function columnsOf(
  scopes: readonly Pick<Scope, 'all'>[],
  variants: readonly string[],
): string[] {
  const drawn = scopes.flatMap(({ all }) =>
    all.flatMap(({ column }) => {
      const difference = differenceOf(column);
      return difference ? [difference.minuend, difference.subtrahend] : [column];
    }),
  );
  return [...new Set([...planeColumns(variants), ...drawn])];
}

/** Whose currents, forces and motion a layout shows. */
export interface Subject {
  variant: string;
  axis: Axis;
}

export interface ShippedLayout {
  name: string;
  meaning: string;
  scopes: (variants: readonly string[], subject: Subject) => ScopeSpec[];
}

const both = (variants: readonly string[], rest: string) =>
  variants.slice(0, 2).map((variant) => `${variant}.${rest}`);

function errorScope(variants: readonly string[], axis: Axis): ScopeSpec {
  const [a, b] = variants;
  const channel = `${axis}.following_error`;
  const difference = a !== undefined && b !== undefined ? [`${a}-${b}.${channel}`] : [];
  // It would cover the curve that it comes from.
  return { ...scopeWith(...both(variants, channel), ...difference), hidden: difference };
}

function motion(variants: readonly string[], axis: Axis, quantity: string): ScopeSpec {
  return scopeWith(`${axis}.${quantity}_reference`, ...both(variants, `${axis}.${quantity}`));
}

function of({ variant, axis }: Subject, ...channels: string[]): ScopeSpec {
  return scopeWith(...channels.map((channel) => `${variant}.${axis}.${channel}`));
}

const currents = (subject: Subject) => of(subject, 'current_a', 'current_b', 'current_c');

export const LAYOUTS: readonly ShippedLayout[] = [
  {
    name: 'Overview',
    meaning: 'Following errors, phase currents, force and friction',
    scopes: (variants, subject) => [
      errorScope(variants, 'x'),
      errorScope(variants, 'y'),
      currents(subject),
      of(subject, 'thrust', 'friction', 'friction_estimate'),
    ],
  },
  {
    name: 'Errors',
    meaning: 'Position against reference and following error of both axes',
    scopes: (variants) => [
      motion(variants, 'x', 'position'),
      errorScope(variants, 'x'),
      motion(variants, 'y', 'position'),
      errorScope(variants, 'y'),
    ],
  },
  {
    name: 'Motion',
    meaning: 'Position, velocity, acceleration and error of one axis',
    scopes: (variants, { axis }) => [
      motion(variants, axis, 'position'),
      motion(variants, axis, 'velocity'),
      motion(variants, axis, 'acceleration'),
      errorScope(variants, axis),
    ],
  },
  {
    name: 'Currents and sharing',
    meaning: 'Commanded and true phase currents, and the thrust they share',
    scopes: (_, subject) => [
      of(subject, 'current_a', 'current_b', 'current_c'),
      of(subject, 'current_command_a', 'current_command_b', 'current_command_c'),
      of(subject, 'force_command', 'force_realised', 'thrust'),
      of(subject, 'normal_force'),
    ],
  },
  {
    name: 'Friction',
    meaning: 'Friction and its estimate, bristle states, velocity and error',
    scopes: (variants, subject) => [
      of(subject, 'friction', 'friction_estimate'),
      of(subject, 'bristle', 'bristle_estimate'),
      motion(variants, subject.axis, 'velocity'),
      errorScope(variants, subject.axis),
    ],
  },
  {
    name: 'Loop effort',
    meaning: 'What feedback, compensation and observer each command, and when they saturate',
    scopes: (variants, subject) => [
      of(subject, 'pd_force', 'friction_estimate', 'disturbance_estimate', 'force_command'),
      of(subject, 'force_saturated', 'current_saturated'),
      errorScope(variants, subject.axis),
    ],
  },
  {
    name: 'Paper figure',
    meaning: 'Following errors of both axes, as in Fig. 5 of the paper',
    scopes: (variants) => [
      scopeWith(...both(variants, 'x.following_error')),
      scopeWith(...both(variants, 'y.following_error')),
    ],
  },
];

/** The same scope of another variant and axis: only one that is of this subject alone changes. */
export function retargeted(spec: ScopeSpec, from: Subject, to: Subject): ScopeSpec {
  const parts = spec.channels.map(partsOf);
  const errors = parts.every(({ quantity }) => quantity === 'following_error');
  if (errors || only(parts.map(({ axis }) => axis)) !== from.axis) return spec;
  const letters = parts.map(({ variant }) => variant).filter(Boolean);
  const whose = only(letters) === from.variant;
  const renamed = (column: string) => {
    const { variant } = partsOf(column);
    const rest = column.slice(variant ? variant.length + 3 : 2);
    return `${variant ? `${whose ? to.variant : variant}.` : ''}${to.axis}.${rest}`;
  };
  return {
    ...spec,
    channels: spec.channels.map(renamed),
    hidden: spec.hidden.map(renamed),
    own: spec.own.map(renamed),
  };
}

/** Channels that are dragged from the list onto a scope. */
export const CHANNEL_TYPE = 'application/x-motionlab-channel';
