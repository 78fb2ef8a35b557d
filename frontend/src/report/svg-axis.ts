/** Axes of a report's pictures, and elements of SVG. */

const SVG = 'http://www.w3.org/2000/svg';

/** Ends of an axis, and their places in the picture. */
export interface Ends {
  low: number;
  high: number;
  begin: number;
  end: number;
}

/** Reads what the report says of an axis. */
export function endsOf(text = ''): Ends {
  const [low = 0, high = 1, begin = 0, end = 1] = text.split(' ').map(Number);
  return { low, high, begin, end };
}

export function placeOf({ low, high, begin, end }: Ends, value: number): number {
  return begin + ((value - low) / (high - low)) * (end - begin);
}

export function element(name: string, attributes: Record<string, string | number>): SVGElement {
  const node = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, String(value));
  return node;
}
