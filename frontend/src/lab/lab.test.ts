import { expect, it, vi } from 'vitest';
import type { Metrics, SessionInfo } from '../api/types';
import { Lab } from './lab.svelte';

vi.hoisted(() => vi.stubGlobal('location', { href: 'http://127.0.0.1/' }));

const settled = () => new Promise((resolve) => setTimeout(resolve, 0));

function measured(end: number): Metrics {
  return { window: { start: 0, end }, variants: { A: {} }, comparison: {} } as unknown as Metrics;
}

/** A Lab whose session has run for a while, and what answers its questions for metrics. */
function playing(): { lab: Lab; answers: ((metrics: Metrics) => void)[] } {
  const lab = new Lab();
  lab.session.info = { id: 'a', time: 1 } as SessionInfo;
  const answers: ((metrics: Metrics) => void)[] = [];
  lab.api.metrics = vi.fn(() => new Promise<Metrics>((resolve) => answers.push(resolve)));
  return { lab, answers };
}

it('shows the metrics of the newest question, however late an older one is answered', async () => {
  const { lab, answers } = playing();
  lab.readMetrics();
  lab.readMetrics();
  lab.readMetrics();
  expect(answers).toHaveLength(1);
  answers[0]?.(measured(1));
  await settled();
  answers[1]?.(measured(2));
  await settled();
  expect(lab.metrics?.window.end).toBe(2);
  expect(answers).toHaveLength(2);
});

it('does not show the metrics of a session that it has left', async () => {
  const { lab, answers } = playing();
  lab.readMetrics();
  lab.session.info = { id: 'b', time: 1 } as SessionInfo;
  answers[0]?.(measured(1));
  await settled();
  expect(lab.metrics).toBeNull();
});
