/**
 * The section of one axis: toothed stator, the three movers of the platform with their coils, the
 * forces. Lengths along the axis are true but for the error, which is magnified; heights are not.
 * The picture rides with the mover, the stator passes below it.
 */

import type { Canvas } from '../../../plot/canvas';
import { magnification } from '../../../plot/mover-plane';
import type { Ink } from '../../../plot/palette';
import { quantity } from '../../../ui/units';
import { CARRIES, forceText, PHASES, turnsOf, type AxisState, type ForceMap } from './phases';

/** Pitches from mover to mover, over all three, and the teeth of one. */
const SPACING = 20 / 3;
const ACROSS = 20;
const TEETH = 6;
/** Shares of the picture's height, from the air gap upwards and downwards. */
const HEIGHTS = { yoke: 0.17, limb: 0.34, tooth: 0.11, gap: 0.07, back: 0.1 };

/** What fills the scales: the largest that flows, acts or strays in the stretch of time. */
export interface Largest {
  current: number;
  force: number;
  error: number;
}

/** A picture lower than this has no line for the error; a higher one has roomier rows. */
const LOW = 130;
const LABEL = 126;

export class SectionDrawing {
  constructor(private readonly canvas: Canvas) {}

  draw(
    state: AxisState,
    map: ForceMap,
    thrusts: readonly number[],
    largest: Largest,
    time: number,
  ): void {
    const { canvas } = this;
    const { width, height } = canvas;
    canvas.clear();
    canvas.font(11);
    const row = height < 200 ? 13 : 16;
    const strip = height < LOW ? 0 : 30;
    const labels = row;
    const forces = (height < LOW ? 2 : 3) * row;
    const pitch = Math.min((width - 12) / ACROSS, 36);
    const reach = Math.min(2.7 * pitch, (width - LABEL) / 2 - 4);
    const scale = largest.force > 0 ? reach / largest.force : 0;
    const top = strip + labels;
    const body = height - top - forces - 6;
    if (strip > 0) this.error(state, largest.error, pitch / map.pitch, time);
    this.iron(state, map, { pitch, top, body, current: largest.current });
    for (const [k, phase] of PHASES.entries()) {
      const x = width / 2 + (k - 1) * SPACING * pitch;
      const force = thrusts[k] ?? Number.NaN;
      const current = state.currents[k] ?? Number.NaN;
      this.label(phase, current, force, x, strip + labels / 2, pitch);
      const y = top + (HEIGHTS.yoke * body) / 2;
      this.arrow(x, y, force * scale, `phase-${phase}`, Math.min(4, 0.1 * body));
    }
    this.forces(state, scale, { row, from: height - forces, reach });
  }

  /** Stator, movers, their coils, and lines from tooth to tooth where current flows. */
  private iron(
    state: AxisState,
    map: ForceMap,
    { pitch, top, body, current }: { pitch: number; top: number; body: number; current: number },
  ): void {
    const { canvas } = this;
    const { c, palette, width } = canvas;
    const yoke = HEIGHTS.yoke * body;
    const limb = HEIGHTS.limb * body;
    const tooth = HEIGHTS.tooth * body;
    const back = HEIGHTS.back * body;
    const sole = top + yoke + limb + tooth;
    const stator = sole + HEIGHTS.gap * body;
    const position = state.reference - state.error;
    const left = width / 2 - SPACING * pitch;
    const turns = turnsOf(map, position);
    const shift = left - (turns[0] ?? 0) * pitch;

    c.fillStyle = palette.reference;
    c.globalAlpha = 0.55;
    c.fillRect(0, stator + tooth, width, back);
    const first = Math.ceil((-pitch - shift) / pitch);
    for (let n = first; shift + (n - 0.25) * pitch < width; n++) {
      c.fillRect(shift + (n - 0.25) * pitch, stator, pitch / 2, tooth);
    }
    c.globalAlpha = 1;

    // The platform joins the movers; its mark stands at the place that the encoder reads.
    c.fillStyle = palette.strong;
    c.fillRect(left - 2.2 * pitch, top - 3, 2 * (SPACING + 2.2) * pitch, 3);
    for (const [k, phase] of PHASES.entries()) {
      const x = width / 2 + (k - 1) * SPACING * pitch;
      const ink = palette[`phase-${phase}`];
      const flows = Math.abs(state.currents[k] ?? 0);
      c.fillStyle = palette.strong;
      c.fillRect(x - 2.2 * pitch, top, 4.4 * pitch, yoke);
      for (const side of [-1.5, 1.5]) {
        c.fillStyle = palette.strong;
        c.fillRect(x + (side - 0.7) * pitch, top + yoke, 1.4 * pitch, limb);
        c.fillRect(x + (side - 1.25) * pitch, top + yoke + 0.8 * limb, 2.5 * pitch, 0.2 * limb);
        for (const edge of [-1.3, 0.75]) {
          const box = [
            x + (side + edge) * pitch,
            top + yoke + 1,
            0.55 * pitch,
            0.74 * limb,
          ] as const;
          c.fillStyle = palette.well;
          c.fillRect(...box);
          c.fillStyle = ink;
          c.globalAlpha = current > 0 ? Math.min(1, flows / current) : 0;
          c.fillRect(...box);
          c.globalAlpha = 1;
          canvas.pen(`phase-${phase}`);
          c.strokeRect(...box);
        }
      }
      c.fillStyle = palette.strong;
      const poles = Array.from({ length: TEETH }, (_, i) => x + (i - (TEETH - 1) / 2) * pitch);
      for (const pole of poles) c.fillRect(pole - pitch / 4, top + yoke + limb, pitch / 2, tooth);
      if (!(flows > CARRIES)) continue;
      const turn = turns[k] ?? 0;
      const over = (0.5 - (turn - Math.floor(turn))) * pitch;
      canvas.pen(`phase-${phase}`, 1 + 1.5 * Math.min(1, flows / (current || 1)));
      canvas.lines(poles.map((pole) => [pole, sole - 1, pole + over, stator + 1]));
    }
  }

  /** Where the reference is, seen from the mover, magnified. */
  private error(
    { reference, error }: AxisState,
    largest: number,
    metre: number,
    time: number,
  ): void {
    const { canvas } = this;
    const { width } = canvas;
    const x = width / 2;
    const y = 21;
    // As wide as the plane has it beside its path.
    const factor = magnification((1.7 * width) / metre, largest);
    const to = x + error * factor * metre;
    canvas.pen('strong');
    canvas.lines([[x, y - 5, x, y + 5]]);
    this.arrow(x, y, to - x, 'reference', 2);
    canvas.dot(to, y, 3, 'reference');
    const [place, away] = [quantity(reference, 'm'), quantity(error, 'm')];
    canvas.write(`at ${time.toFixed(2)} s`, 4, 8, { ink: 'muted' });
    canvas.write(`reference ${place.number} ${place.unit}`, 4, y, { ink: 'muted' });
    canvas.write(`error ${away.number} ${away.unit}`, width - 4, 8, {
      align: 'right',
      ink: 'text',
    });
    canvas.write(`× ${factor.toLocaleString('en')}`, width - 4, y, {
      align: 'right',
      ink: 'muted',
    });
  }

  private label(
    phase: string,
    current: number,
    force: number,
    x: number,
    y: number,
    pitch: number,
  ): void {
    const { canvas } = this;
    const half = 3 * pitch;
    const places = half > 60 ? 2 : 1;
    const amperes = Number.isFinite(current) ? `${current.toFixed(places)} A` : '–';
    canvas.font(12, 600);
    canvas.write(phase, x - half, y, { ink: 'text' });
    canvas.font(11);
    canvas.write(amperes, x + half * 0.12, y, { align: 'right', ink: 'text' });
    canvas.write(forceText(force, places), x + half, y, { align: 'right', ink: 'text' });
  }

  /** Thrust of the whole axis and friction against it: how much, and by an arrow which way. */
  private forces(
    { thrust, friction, estimate }: AxisState,
    scale: number,
    { row, from, reach }: { row: number; from: number; reach: number },
  ): void {
    const { canvas } = this;
    const x = Math.max(canvas.width / 2, LABEL + reach);
    const rows: [string, number, Ink, boolean][] = [
      ['thrust', thrust, 'text', false],
      ['friction', -friction, 'muted', false],
      ['estimated', -estimate, 'muted', true],
    ];
    const end = from + rows.length * row;
    canvas.pen('border');
    canvas.lines([[x, from, x, Math.min(end, canvas.height)]]);
    rows.forEach(([name, force, ink, dashed], i) => {
      const y = from + (i + 0.5) * row;
      if (y > canvas.height) return;
      canvas.write(name, 4, y, { ink: 'muted' });
      canvas.write(forceText(Math.abs(force)), LABEL - 8, y, { align: 'right', ink: 'text' });
      this.arrow(x, y, force * scale, ink, 3, dashed);
    });
  }

  private arrow(
    x: number,
    y: number,
    length: number,
    ink: Ink,
    width: number,
    dashed = false,
  ): void {
    const { canvas } = this;
    const { c } = canvas;
    if (!(Math.abs(length) > 1)) return;
    const head = Math.min(3 * width, Math.abs(length)) * Math.sign(length);
    const tip = x + length;
    if (!dashed) {
      canvas.pen('panel', width + 3);
      canvas.lines([[x, y, tip - head / 2, y]]);
    }
    canvas.pen(ink, width, dashed ? 'dot' : 'solid');
    canvas.lines([[x, y, tip - head / 2, y]]);
    c.fillStyle = canvas.palette[ink];
    c.beginPath();
    c.moveTo(tip, y);
    c.lineTo(tip - head, y - Math.abs(head) / 1.6);
    c.lineTo(tip - head, y + Math.abs(head) / 1.6);
    c.fill();
  }
}
