/** Which words of a text are terms of the glossary. */

import type { TermName } from './glossary';

/** Words as the screens write them, in any case. */
const PHRASES: Readonly<Record<string, TermName>> = {
  'gain margin': 'GM',
  GM: 'GM',
  'phase margin': 'PM',
  PM: 'PM',
  M_s: 'M_s',
  'K = 0': 'K = 0',
  LuGre: 'LuGre',
  'least norm': 'least norm',
  'force sharing': 'force sharing',
  'disturbance observer': 'DOB',
  DOB: 'DOB',
  feedforward: 'feedforward',
  notch: 'notch',
  'friction compensation': 'compensation',
  compensation: 'compensation',
  'following error': 'following error',
  'max |e_x|': 'following error',
  'max |e_y|': 'following error',
  'max |e|': 'following error',
  'peak error': 'following error',
  contour: 'contour error',
  steady: 'steady error',
  settling: 'settling time',
  'settling time': 'settling time',
  overshoot: 'overshoot',
  ITAE: 'ITAE',
  RMS: 'RMS',
  saturated: 'saturated',
  k_p: 'k_p',
  k_d: 'k_d',
  v_s: 'Stribeck velocity',
  F_s: 'stiction',
  stiction: 'stiction',
  'stiction F_s': 'stiction',
  F_c: 'Coulomb friction',
  σ_0: 'sigma_0',
  σ_1: 'sigma_1',
  σ_2: 'sigma_2',
  crossover: 'crossover',
  bandwidth: 'bandwidth',
  cost: 'cost',
  simplex: 'simplex',
  'pole pitch': 'pole pitch',
  'pole pitches': 'pole pitch',
  'air gap': 'air gap',
  'force map': 'force map',
};

const BY_WORDS = new Map(
  Object.entries(PHRASES).map(([words, term]) => [words.toLowerCase(), term]),
);
const escaped = (words: string) => words.replace(/[|()]/g, '\\$&');
/** The longest first; a letter, digit or subscript beside it makes it another word. */
const ANY = new RegExp(
  `(?<![\\p{L}\\d_|])(${Object.keys(PHRASES)
    .sort((one, other) => other.length - one.length)
    .map(escaped)
    .join('|')})(?![\\p{L}\\d_])`,
  'giu',
);

interface Part {
  text: string;
  term: TermName | null;
}

/** Cuts a text into its terms and what is between them. */
export function partsOf(text: string): Part[] {
  return text
    .split(ANY)
    .map((part, i) => ({ text: part, term: i % 2 === 1 ? termOf(part) : null }))
    .filter((part) => part.text !== '');
}

/** The first term of a text. */
export function termIn(text: string): TermName | null {
  return partsOf(text).find(({ term }) => term)?.term ?? null;
}

function termOf(words: string): TermName | null {
  return BY_WORDS.get(words.toLowerCase()) ?? null;
}
