/** A figure of the paper as Plot takes it. */

import type { PaperFigure } from '../../app/api/types';
import type { Ink } from '../../plot/palette';
import type { PlotAxis, Band, Dash, Mark, Series } from '../../plot/types';

type Role = PaperFigure['series'][number]['role'];

/** Each role has a colour and, beside it, a dash or a marker of its own. */
const DRAWN: Readonly<Record<Role, { ink: Ink; dash: Dash; marker: Series['marker'] }>> = {
  A: { ink: 'a', dash: 'solid', marker: 'square' },
  B: { ink: 'b', dash: 'dash', marker: 'circle' },
  reference: { ink: 'reference', dash: 'dot', marker: 'plus' },
  'phase-a': { ink: 'phase-a', dash: 'solid', marker: 'circle' },
  'phase-b': { ink: 'phase-b', dash: 'dash', marker: 'square' },
  'phase-c': { ink: 'phase-c', dash: 'dot', marker: 'triangle' },
  x: { ink: 'phase-a', dash: 'solid', marker: 'square' },
  y: { ink: 'phase-b', dash: 'dash', marker: 'circle' },
  printed: { ink: 'text', dash: 'dashdot', marker: 'diamond' },
};

/** Distinguishes several series of one role. */
const DASHES: readonly Dash[] = ['dot', 'dash', 'dashdot', 'solid'];
const MARKERS: readonly Series['marker'][] = ['diamond', 'triangle', 'square', 'cross'];

export interface Drawing {
  x: PlotAxis;
  y: PlotAxis;
  series: Series[];
  bands: Band[];
  marks: Mark[];
  equal: boolean;
}

export function drawingOf(figure: PaperFigure): Drawing {
  const series = figure.series.map((one, i): Series => {
    const before = figure.series.slice(0, i).filter(({ role }) => role === one.role).length;
    const several = figure.series.filter(({ role }) => role === one.role).length > 1;
    const { ink } = DRAWN[one.role];
    const dash = several ? (DASHES[before % DASHES.length] ?? 'solid') : DRAWN[one.role].dash;
    const marker = several ? MARKERS[before % MARKERS.length] : DRAWN[one.role].marker;
    const base = { name: one.label, x: one.x, y: one.y, ink };
    return one.kind === 'points'
      ? { ...base, kind: 'points', ...(marker ? { marker } : {}) }
      : { ...base, dash };
  });
  const ends = endsOf(figure);
  const marks = figure.bounds.flatMap(({ label, low, high, start, end }): Mark[] =>
    start === null && end === null
      ? [low, high].flatMap((at) =>
          at === null ? [] : [{ axis: 'y' as const, at, label, ink: 'text' as const }],
        )
      : [],
  );
  const bands = figure.bounds.flatMap(({ label, low, high, start, end }): Band[] =>
    (start === null && end === null) || low === null || high === null
      ? []
      : [
          {
            name: label,
            x: [start ?? ends[0], end ?? ends[1]],
            low: [low, low],
            high: [high, high],
            ink: 'text',
          },
        ],
  );
  return {
    x: { label: figure.x.label, unit: figure.x.unit, log: figure.x.log },
    y: { label: figure.y.label, unit: figure.y.unit, log: figure.y.log },
    series,
    bands,
    marks: apart(marks),
    equal: figure.x.unit === figure.y.unit && figure.x.unit === 'm' && figure.x.label !== 'time',
  };
}

function endsOf(figure: PaperFigure): [number, number] {
  const places = figure.series.flatMap(({ x }) => (x.length > 0 ? [x[0], x[x.length - 1]] : []));
  const known = places.filter((place): place is number => place !== undefined);
  return known.length > 0 ? [Math.min(...known), Math.max(...known)] : [0, 1];
}

/** Of the two ends of one bound only the first is labelled. */
function apart(marks: readonly Mark[]): Mark[] {
  const seen = new Set<string>();
  return marks.map((mark) => {
    if (seen.has(mark.label)) return { ...mark, label: '' };
    seen.add(mark.label);
    return mark;
  });
}
