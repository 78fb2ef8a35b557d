/** Another law in a recorded stretch: what is asked for, and its curves and figures. */

import type { RequestOf } from '../../../app/api/operations';
import { equal } from '../../../app/api/scenario-paths';
import type { Changes, Choice, Parts, RunDetail, Schemas } from '../../../app/api/types';
import { looksOf } from '../../../plot/palette';
import type { Band, Series } from '../../../plot/types';
import type { FinderOption } from '../../../ui/finder';
import { digits, inScale, scaleOf, spanText } from '../../../ui/units';

export type MinuteDocument = Schemas['MinuteDocument'];
type MinuteAxis = Schemas['MinuteAxis'];
/** All of a request but its run. */
export type MinuteForm = Omit<RequestOf<'/minute'>, 'run'> & { readonly set?: Changes };

/** The unit of following errors. */
export const MICRO = { factor: 1e6, unit: 'µm' };

/** Letters of the controllers that a run's scenario has. */
export function lettersOf({ scenario_document, variants }: RunDetail): readonly string[] {
  const document = scenario_document as { variants?: object } | null;
  return document?.variants ? Object.keys(document.variants) : variants;
}

/** A form with the server's defaults in place of what is left open. */
export function filled(form: MinuteForm, run: RunDetail) {
  const letters = lettersOf(run);
  return {
    variant: form.variant ?? run.variants[0] ?? 'A',
    other: form.other ?? letters[1] ?? letters[0] ?? 'A',
    set: form.set ?? {},
    start: form.start ?? 0,
    end: form.end ?? run.duration,
  };
}

/** Names of the settings in which a form differs from a request. */
export function differing(form: MinuteForm, request: MinuteForm, run: RunDetail): string[] {
  const [now, then] = [filled(form, run), filled(request, run)];
  return [
    ...(now.variant === then.variant ? [] : ['record']),
    ...(now.other === then.other && equal(now.set, then.set) ? [] : ['controller that is tried']),
    ...(now.start === then.start && now.end === then.end ? [] : ['stretch']),
  ];
}

/** Controllers that can be tried: as the run has it, a shipped one, or it with another law. */
export function controllerOptions(
  { controllers }: Pick<Parts, 'controllers'>,
  laws: readonly Choice[],
  present: string,
): FinderOption[] {
  return [
    { value: '', name: 'as in the run', detail: present },
    ...controllers.map(({ name, description }) => ({
      value: `controller:${name}`,
      name,
      title: description,
      group: 'Controllers that ship',
    })),
    ...laws.map(({ value, label, description }) => ({
      value: `law:${value}`,
      name: label,
      title: description,
      group: 'As in the run, with the compensation',
    })),
  ];
}

/** The changes of the scenario that make a controller the one that is chosen. */
export function changesOf(choice: string, variant: string): Changes {
  const path = `variants.${variant}.controller`;
  const [kind, name = ''] = choice.split(':', 2);
  if (kind === 'controller') return { [path]: name };
  if (kind !== 'law') return {};
  const law = { [`${path}.compensation.law`]: name };
  return name === 'off' ? law : { ...law, [`${path}.compensation.enabled`]: true };
}

/** The choice that makes these changes; null where they were made elsewhere. */
export function choiceOf(
  set: Changes,
  variant: string,
  options: readonly FinderOption[],
): string | null {
  return options.find(({ value }) => equal(changesOf(value, variant), set))?.value ?? null;
}

/** A request in the list of earlier ones. */
export function describe(request: Record<string, unknown>): string {
  const { other, set, start, end } = request as MinuteForm;
  const tried = Object.values(set ?? {}).filter((value) => typeof value === 'string');
  const part = typeof end === 'number' ? spanText({ start: start ?? 0, end }) : '';
  return [other ?? '', ...tried, part].filter(Boolean).join(' ');
}

/** Which curves there are beside the predicted one, whose axis is finer alone. */
export interface ErrorCurves {
  recorded: boolean;
  /** The recorded controller on the fitted motor: how well that repeats the record. */
  again: boolean;
}

/** Recorded and predicted errors of an axis. */
export function errorSeries(
  { variant, other }: Pick<MinuteDocument, 'variant' | 'other'>,
  { time: x, recorded, again, predicted }: MinuteAxis['errors'],
  shown: ErrorCurves,
): Series[] {
  const { ink = 'a' } = looksOf(variant);
  const curves: (Series & { on: boolean })[] = [
    { name: `${variant} recorded`, x, y: recorded, ink, on: shown.recorded },
    {
      name: `${variant} simulated again`,
      x,
      y: again,
      ink: 'text',
      dash: 'dot',
      width: 1,
      on: shown.again,
    },
    {
      name: `${other} predicted`,
      x,
      y: predicted,
      ink: 'candidate',
      dash: 'dash',
      width: 1.2,
      on: true,
    },
  ];
  return curves.filter(({ on }) => on);
}

export function errorBand({ time, low, high }: MinuteAxis['errors']): Band {
  return { name: '95 %', x: time, low, high, ink: 'candidate' };
}

export interface ErrorRow {
  name: string;
  /** Recorded, predicted, its interval, and their ratio. */
  cells: string[];
}

/** Largest and rms following errors of every axis, µm. */
export function errorRows(axes: MinuteDocument['axes']): ErrorRow[] {
  return Object.entries(axes).flatMap(([axis, of]) =>
    (
      [
        [`max |e_${axis}|`, of.max_recorded, of.max_predicted],
        [`RMS e_${axis}`, of.rms_recorded, of.rms_predicted],
      ] as const
    ).map(([name, recorded, { value, low, high }]) => ({
      name,
      cells: [
        inScale(recorded, MICRO),
        inScale(value, MICRO),
        `${inScale(low, MICRO)} to ${inScale(high, MICRO)}`,
        recorded > 0 ? digits(value / recorded) : '–',
      ],
    })),
  );
}

export interface MotorRow {
  name: string;
  unit: string;
  /** Believed, fitted, and its interval. */
  cells: string[];
}

/** The motor of an axis, in the newtons of the controller's map. */
export function motorRows({ motor }: Pick<MinuteAxis, 'motor'>): MotorRow[] {
  return Object.entries(motor).map(([name, { value, low, high, believed, unit }]) => {
    const scale = scaleOf([value, low, high, believed], unit);
    const [was, is, from, to] = [believed, value, low, high].map((each) => inScale(each, scale));
    return { name, unit: scale.unit, cells: [was, is, `${from} to ${to}`] as string[] };
  });
}

/** What an axis tells about the prediction. */
export function evidence(axis: string, { reversals, disturbance, miss }: MinuteAxis): string {
  return (
    `${axis}: ${reversals} reversals, disturbance ${digits(disturbance)} N rms; ` +
    `the recorded controller, simulated again, misses its record by ${inScale(miss, MICRO)} µm rms.`
  );
}
