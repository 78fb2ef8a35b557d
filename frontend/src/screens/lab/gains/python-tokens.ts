/** Python as lines of coloured parts: enough for the file of a law. */

type Kind = 'comment' | 'string' | 'decorator' | 'number' | 'keyword';

/** A part of a line; of no kind: names, signs and space. */
export interface Part {
  kind: Kind | '';
  text: string;
}

const KEYWORDS =
  'and|as|assert|async|await|break|case|class|continue|def|del|elif|else|except|False|finally|for|from|global|' +
  'if|import|in|is|lambda|match|None|nonlocal|not|or|pass|raise|return|True|try|while|with|yield';

/** A string without an end goes to that of its line, or, with three quotes, of the text. */
const STRINGS = [
  /"""(?:\\[^]|[^])*?(?:"""|(?![^]))/,
  /'''(?:\\[^]|[^])*?(?:'''|(?![^]))/,
  /"(?:\\[^]|[^"\\\n])*"?/,
  /'(?:\\[^]|[^'\\\n])*'?/,
].map(({ source }) => source);
const NUMBERS = [
  /\b0[xX][\da-fA-F_]+/,
  /\b0[bBoO][\d_]+/,
  /(?:\b\d[\d_]*\.?[\d_]*|(?<!\w)\.\d[\d_]*)(?:[eE][+-]?\d+)?j?/,
].map(({ source }) => source);

/** In the order in which they are tried at each place. */
const PATTERNS: readonly (readonly [Kind, string])[] = [
  ['comment', '#.*'],
  ['string', `(?:\\b(?:[rR][bBfF]?|[bBfF][rR]?|[uU]))?(?:${STRINGS.join('|')})`],
  ['decorator', '(?<=^[ \\t]*)@[\\w.]+'],
  ['number', NUMBERS.join('|')],
  ['keyword', `\\b(?:${KEYWORDS})\\b`],
];
const TOKEN = new RegExp(
  PATTERNS.map(([kind, pattern]) => `(?<${kind}>${pattern})`).join('|'),
  'gm',
);

export function pythonLines(source: string): Part[][] {
  const lines: Part[][] = [[]];
  const add = (kind: Part['kind'], text: string) => {
    text.split('\n').forEach((part, i) => {
      if (i > 0) lines.push([]);
      if (part !== '') lines.at(-1)?.push({ kind, text: part });
    });
  };
  let end = 0;
  for (const match of source.matchAll(TOKEN)) {
    const [kind = ''] = PATTERNS.find(([each]) => match.groups?.[each] !== undefined) ?? [];
    add('', source.slice(end, match.index));
    add(kind, match[0]);
    end = match.index + match[0].length;
  }
  add('', source.slice(end));
  if (lines.length > 1 && lines.at(-1)?.length === 0) lines.pop();
  return lines;
}
