/** Columns that are computed from channels: `name=expression`, with or without a name. */

/** Characters of a name and of an expression. */
export const NAME_MAX = 40;
export const EXPRESSION_MAX = 200;

/** Most that are computed at once. */
export const MATH_MAX = 32;

const LABEL_MAX = 32;

export { isMath } from './source';

export interface MathParts {
  name: string;
  expression: string;
}

export function mathParts(column: string): MathParts {
  const at = column.indexOf('=');
  return { name: column.slice(0, at).trim(), expression: column.slice(at + 1).trim() };
}

export function mathColumn({ name, expression }: MathParts): string {
  return `${name.trim()}=${expression.trim()}`;
}

/** What a math channel is called where there is little room: its name, or how its expression begins. */
export function mathLabel(column: string): string {
  const { name, expression } = mathParts(column);
  const text = name || expression;
  return text.length > LABEL_MAX && name === '' ? `${text.slice(0, LABEL_MAX - 1)}…` : text;
}

/** What keeps math channels from being computed beside the ones before them, by column. */
export function refusedBeside(columns: readonly string[]): ReadonlyMap<string, string> {
  const problems = new Map<string, string>();
  const taken = new Set<string>();
  for (const column of columns) {
    const { name, expression } = mathParts(column);
    const called = name || expression;
    if (taken.has(called))
      problems.set(column, `another channel is called ${called}; choose another name`);
    else if (taken.size === MATH_MAX) {
      problems.set(column, `${MATH_MAX} math channels are the most at once; delete one`);
    } else taken.add(called);
  }
  return problems;
}
