/** Which friction model a run supports: the request of the form's run, and a result in rows. */

import type { RequestOf } from '../../app/api/operations';
import type { FrictionModels } from '../../app/api/types';
import { quantity } from '../../ui/units';
import type { Body } from './experiment-form.svelte';

export type ModelsRequest = RequestOf<'/friction-models'>;

/** A model's held-out error, and by how much it is above the least. */
export interface ModelRow {
  name: string;
  label: string;
  parameters: number;
  error: string;
  more: string;
  selected: boolean;
}

/** Returns the request of models, and effects, on one axis of the run that the form reads. */
export function modelsRequest(
  body: Body,
  axis: 'x' | 'y',
  effects: readonly string[],
): ModelsRequest | null {
  const { run, record, scenario, set } = body;
  return run ? { ...record, run, axis, scenario, set, effects: [...effects] } : null;
}

export function modelRows({ models, best, selected, force_unit }: FrictionModels): ModelRow[] {
  const text = (force: number) => {
    const { number, unit } = quantity(force, force_unit);
    return `${number} ${unit}`;
  };
  return models.map((model) => ({
    name: model.name,
    label: model.label,
    parameters: model.complexity,
    error: text(model.error),
    more: model.name === best ? '–' : `${text(model.difference)} ± ${text(model.difference_error)}`,
    selected: model.name === selected,
  }));
}

/** Returns what is selected, or between which models it cannot be told. */
export function verdict({ models, selected, among, describes }: FrictionModels): string {
  const but = describes ? '' : '; none of the models describes this friction';
  const label = (name: string) => models.find((model) => model.name === name)?.label;
  if (selected !== null) return `${label(selected) ?? selected}${but}`;
  const tried = among.flatMap((name) => label(name) ?? []);
  return `cannot tell${tried.length > 1 ? `: ${tried.join(', ')}` : ''}${but}`;
}
