/** The readings of a design in the order in which they are shown. */

import type { DesignDocument, Reading } from '../../../app/api/types';
import type { Direction } from './sizing-fields';

export interface Section {
  title: string;
  readings: Reading[];
}

function isReading(value: unknown): value is Reading {
  return typeof value === 'object' && value !== null && 'used_form' in value;
}

const readingsOf = (table: object): Reading[] => Object.values(table).filter(isReading);

export function sectionsOf(design: DesignDocument, direction: Direction): Section[] {
  if (direction === 'requirements') return [{ title: '', readings: readingsOf(design.sizing) }];
  const { rating } = design;
  if (!rating) return [];
  return [
    { title: 'Axis x', readings: readingsOf(rating.x) },
    { title: 'Axis y', readings: readingsOf(rating.y) },
    { title: 'Motor', readings: readingsOf(rating) },
  ];
}

/** A printed number agrees if it is ours but for its last digit. */
const ROUNDING = 0.005;
const NUMBER_ONLY = 'a number without formula';

/** Whether what is used is another formula or another number than what is printed. */
export function differs({ printed_form, used_form, printed_value, value }: Reading): boolean {
  if (printed_form === '' || printed_form === used_form) return false;
  if (!printed_form.startsWith('M = ') && printed_form !== NUMBER_ONLY) return true;
  if (printed_value === null || value === null) return false;
  return Math.abs(printed_value - value) > ROUNDING * Math.abs(value);
}
