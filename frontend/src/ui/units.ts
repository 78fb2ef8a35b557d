/**
 * How numbers look: three significant digits, an SI prefix that brings them between 1 and 1000, and
 * a true minus sign. Everything else in the page is SI without prefixes.
 */

const PREFIXES = [
  { factor: 1e9, symbol: 'G' },
  { factor: 1e6, symbol: 'M' },
  { factor: 1e3, symbol: 'k' },
  { factor: 1, symbol: '' },
  { factor: 1e-3, symbol: 'm' },
  { factor: 1e-6, symbol: 'µ' },
  { factor: 1e-9, symbol: 'n' },
  { factor: 1e-12, symbol: 'p' },
] as const;

/** What is smaller is shown as zero: a current that has all but decayed, not 8e-12 pA. */
const LEAST = 1e-12;

/** Units that take a prefix in front; the others, such as s², kg or a pure number, are left alone. */
const SCALED = new Set([
  'm',
  'm/s',
  'm/s²',
  'N',
  'N/m',
  'N s/m',
  'A',
  'A/m',
  'Hz',
  's',
  'm s',
  'J',
  'W',
  'V',
  'T',
  'Wb',
  'H',
  'Pa',
]);

const SUPERSCRIPTS: Record<string, string> = { '^2': '²', '^3': '³', '^4': '⁴' };

export interface Scale {
  /** Multiply an SI value by this to get the displayed number. */
  factor: number;
  /** Unit with its prefix. */
  unit: string;
}

/** Returns a unit as people write it: `m/s^2` becomes `m/s²`, the pure number `1` nothing. */
export function prettyUnit(unit: string): string {
  if (unit === '1') return '';
  return unit.replace(/\^[234]/g, (power) => SUPERSCRIPTS[power] ?? power);
}

/** Chooses the prefix with which `magnitude` reads between 1 and 1000. */
export function scaleFor(magnitude: number, unit: string): Scale {
  const pretty = prettyUnit(unit);
  // The prefix would be squared or cubed: m s^2 scales by its m, which is linear; s^2 would not.
  const scalable = SCALED.has(pretty) || pretty === 'm s²';
  const size = Math.abs(magnitude);
  if (!scalable || !Number.isFinite(size) || size === 0) return { factor: 1, unit: pretty };
  // Half a digit of slack: 999.6 would be printed as 1000.
  const prefix = PREFIXES.find((p) => size >= p.factor * 0.9995) ?? PREFIXES[PREFIXES.length - 1];
  if (prefix === undefined) return { factor: 1, unit: pretty };
  return { factor: 1 / prefix.factor, unit: prefix.symbol + pretty };
}

/** Chooses the prefix for values that share a unit; those that are not there have no say. */
export function scaleOf(values: readonly number[], unit: string): Scale {
  return scaleFor(Math.max(0, ...values.filter(Number.isFinite).map(Math.abs)), unit);
}

/** Writes a number with `digits` significant digits, never in exponential notation below 1e9. */
export function digits(value: number, significant = 3): string {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const rounded = Number(value.toPrecision(significant));
  const size = Math.abs(rounded);
  const text =
    size >= 1e9 || size < 1e-4
      ? rounded.toExponential(significant - 1)
      : rounded.toFixed(Math.max(0, significant - 1 - Math.floor(Math.log10(size))));
  return minus(text);
}

/** A factor on an amplitude, such as a gain margin, dB. */
export const decibels = (factor: number): number => 20 * Math.log10(factor);

export const degrees = (rad: number): number => (rad * 180) / Math.PI;

/** Writes simulated over real time. */
export function speedText(speed: number): string {
  return `${Number(speed.toPrecision(2))} ×`;
}

/** Replaces the hyphen by a minus sign, which is as wide as a plus and a digit. */
export function minus(text: string): string {
  return text.replace(/-/g, '−');
}

/** How gains, sigma_0 and sigma_1 are written on every screen and in the paper, whatever their size. */
export const PER_MM = {
  stiffness: { factor: 1e-3, unit: 'N/mm' },
  damping: { factor: 1e-3, unit: 'N s/mm' },
} as const satisfies Record<string, Scale>;

export interface Quantity {
  number: string;
  unit: string;
}

/** Formats an SI value with a prefix of its own. */
export function quantity(value: number | null | undefined, unit: string): Quantity {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return { number: '–', unit: prettyUnit(unit) };
  }
  if (Math.abs(value) < LEAST) return { number: '0', unit: prettyUnit(unit) };
  const scale = scaleFor(value, unit);
  return { number: digits(value * scale.factor), unit: scale.unit };
}

/** Writes an SI value in a unit that others share: three digits, but no more than three decimals. */
export function inScale(value: number, { factor }: Scale): string {
  if (!Number.isFinite(value)) return '–';
  const shown = value * factor;
  return Math.abs(shown) < 0.1 ? digits(Number(shown.toFixed(3)), 2) : digits(shown);
}

/**
 * Writes an SI value in the unit of a column: three digits, or fewer of what is small beside others.
 */
export function among(value: number, { factor }: Scale): string {
  if (!Number.isFinite(value)) return '–';
  if (Math.abs(value) < LEAST) return '0';
  const shown = value * factor;
  const size = Math.abs(shown);
  if (size < 0.001) return '<0.001';
  return digits(shown, size < 0.1 ? 2 : 3);
}

/** Formats a share as per cent with its sign: -0.8746 becomes −87.5 %. */
export function percent(share: number | null | undefined): string {
  if (share === null || share === undefined || !Number.isFinite(share)) return '–';
  const value = share * 100;
  if (Math.abs(value) < 0.05) return '0 %';
  const text = Math.abs(value) >= 100 ? value.toFixed(0) : value.toFixed(1);
  return `${value > 0 ? '+' : ''}${minus(text)} %`;
}

/** Formats a stretch of time: 4.5 to 10.5 s. */
export function spanText({ start, end }: { start: number; end: number }): string {
  // Decimals enough to resolve a tenth of the span.
  const places = end > start ? Math.ceil(1 - Math.log10(end - start)) : 2;
  const text = (time: number) => String(Number(time.toFixed(Math.min(6, Math.max(2, places)))));
  return `${text(start)} to ${text(end)} s`;
}

/** Formats seconds as a clock, m:ss.mmm. */
export function clock(seconds: number): string {
  const millis = Math.round(Math.max(0, seconds) * 1000);
  const minutes = Math.floor(millis / 60_000);
  const rest = (millis - minutes * 60_000) / 1000;
  return `${minutes}:${rest.toFixed(3).padStart(6, '0')}`;
}

/**
 * Reads a typed number, in displayed units. A decimal comma is taken as a point.
 *
 * @returns the number, or null when the text is none
 */
export function parseNumber(text: string): number | null {
  const plain = text.trim().replace(/[−–]/g, '-').replace(',', '.');
  if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain)) return null;
  const value = Number(plain);
  return Number.isFinite(value) ? value : null;
}

/** Rounds away what only the change of unit brought in: 0.1 + 0.2 times 1e3 and back. */
export function clean(value: number): number {
  return Number(value.toPrecision(12));
}

const GREEK: Readonly<Record<string, string>> = {
  sigma: 'σ',
  tau: 'τ',
  lambda: 'λ',
  zeta: 'ζ',
  gamma: 'γ',
};

/** Writes an ASCII text of the server with its symbols. */
export function pretty(text: string): string {
  return text
    .replace(/\bum\b/g, 'µm')
    .replace(/\b(sigma|tau|lambda|zeta|gamma)(?![a-z])/g, (name) => GREEK[name] ?? name)
    .replace(/\^[234]/g, (power) => ({ '^2': '²', '^3': '³', '^4': '⁴' })[power] ?? power)
    .replace(/\+-/g, '±')
    .replace(/(^|[[\s(=])-(?=\d)/g, '$1−');
}

/** An age in words that do not change faster than they can be read. */
export function ageText(seconds: number): string {
  if (seconds < 60) return `${Math.round(seconds)} s`;
  if (seconds < 3600) return `${Math.floor(seconds / 60)} min`;
  return `${Math.floor(seconds / 3600)} h`;
}

/** Writes a length of time: 12.5 s, 4 min 3 s. */
export function durationText(seconds: number): string {
  if (seconds < 120) return `${digits(seconds, 3)} s`;
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

const FORMULA: readonly [RegExp, string][] = [
  [/\bDelta /g, 'Δ'],
  [/\bdelta_/g, 'δ_'],
  [/\btau\b/g, 'τ'],
  [/\bsigma\b/g, 'σ'],
  [/\blambda\b/g, 'λ'],
  [/\bpsi\b/g, 'ψ'],
  [/\bmu_/g, 'μ_'],
  [/\bsqrt\(/g, '√('],
  [/ - /g, ' − '],
  [/\^2/g, '²'],
];

/** Writes the letters of a formula: tau as τ. Subscripts are left to ui/Symbol. */
export function formula(text: string): string {
  return FORMULA.reduce((done, [word, letter]) => done.replace(word, letter), text);
}
