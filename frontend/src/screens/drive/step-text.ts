/** The steps of commissioning in words. */

import type { DriveStatus } from '../../app/api/types';
import { digits, minus } from '../../ui/units';
import type { Change, Step } from './commissioning.svelte';

const USUAL = '127.0.0.1:34980'; // of motionlab vdrive without --address

/** A value of a change, with its unit. */
export function valueText(path: string, value: number): string {
  if (path.endsWith('.offset')) return `${minus((1e3 * value).toFixed(4))} mm`;
  return minus(String(value));
}

/** A change in one line: what the file has, and what takes its place. */
export function changeText({ path, now, then }: Change): string {
  return `${path} ${valueText(path, now)} → ${valueText(path, then)}`;
}

/** What the button of the present step says; dots where it asks first. */
export function actionText({ name, torque }: Step): string {
  return torque ? 'Begin…' : name === 'encoders' ? 'Begin' : 'Check';
}

export function markOf({ state, finding }: Step): '✓' | '✗' | '▸' | '' {
  if (state === 'done') return '✓';
  if (finding?.holds === false) return '✗';
  return state === 'now' ? '▸' : '';
}

/** What moves at the moment: positions, and the largest current of a phase. */
export function liveText({ axes, drives }: DriveStatus): string {
  const places = axes.map(
    ({ axis, position }) => `${axis} ${minus((1e3 * position).toFixed(3))} mm`,
  );
  const most = Math.max(...drives.map(({ current }) => Math.abs(current)));
  return `${places.join(', ')}, up to ${digits(most)} A`;
}

/** The command that pushes the mover of a virtual drive along the first axis not yet moved. */
export function pushText({ bus }: DriveStatus, travel: readonly (number | null)[]): string {
  const axis = (travel[0] ?? null) === null ? 'x' : 'y';
  const at = bus.carrier === 'udp' && bus.place !== USUAL ? ` --address ${bus.place}` : '';
  return `motionlab vdrive${at} --switch 'push={axis="${axis}", force=8, time=0.1}'`;
}

/** Figures of a finding as the page writes numbers: the server's have hyphens for minus signs. */
export function figureText(text: string): string {
  return text.replace(/(?<![\w.])-(?=\d)/g, minus);
}
