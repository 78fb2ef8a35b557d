/** Figures of the stream and of drawing for the status line, once a second. */

import { noteRate, watchLine } from '../../app/line-rate';
import { loop } from '../../ui/animation-loop';
import { app } from '../../app/store.svelte';

const PERIOD = 1000;

class Status {
  /** Samples of each channel received a second. */
  samples = $state(0);
  dropped = $state(0);
  /** Samples of each channel that come for a second; 0 where all do. */
  thinned = $state(0);
  /** Longest time from a sample to the picture that shows it, and the part of the line, ms. */
  latency = $state(0);
  line = $state(0);
  /** Mean time between frames, ms. */
  interval = $state(0);
  /** Pictures a second, and ms of script for each. */
  rate = $state(0);
  script = $state(0);
  private before = { samples: 0, frames: 0, bytes: 0, at: 0, drawn: 0, script: 0 };
  private worst = 0;
  private seen = 0;

  /** Starts counting; returns what stops it. */
  start(): () => void {
    const remove = loop.add(() => {
      const at = app.session.client?.receivedAt ?? 0;
      if (at === this.seen || at === 0) return;
      this.seen = at;
      this.worst = Math.max(this.worst, performance.now() - at);
    });
    const timer = setInterval(() => this.count(), PERIOD);
    const unwatch = watchLine();
    return () => {
      remove();
      unwatch();
      clearInterval(timer);
    };
  }

  private count(): void {
    const counts = app.session.client?.counts ?? { samples: 0, frames: 0, dropped: 0, bytes: 0 };
    const now = performance.now();
    const { before } = this;
    const seconds = (now - before.at) / 1000;
    // A new client counts from 0 again.
    const samples = Math.max(0, counts.samples - before.samples);
    const frames = Math.max(0, counts.frames - before.frames);
    this.samples = samples / seconds;
    this.interval = frames > 0 ? (1000 * seconds) / frames : 0;
    this.dropped = counts.dropped;
    const { client, moments } = app.session;
    const stride = client?.stride ?? 1;
    this.thinned = stride > 1 && moments.period > 0 ? 1 / (moments.period * stride) : 0;
    this.line = 1000 * (client?.delay ?? 0);
    this.latency = this.line + this.worst;
    this.worst = 0;
    const { frames: drawn, script } = loop.counts;
    const pictures = drawn - before.drawn;
    this.rate = pictures / seconds;
    this.script = pictures > 0 ? (script - before.script) / pictures : 0;
    const bytes = counts.bytes - before.bytes;
    if (this.thinned > 0 && bytes > 0) noteRate(bytes / seconds);
    this.before = {
      samples: counts.samples,
      frames: counts.frames,
      bytes: counts.bytes,
      at: now,
      drawn,
      script,
    };
  }
}

export const status = new Status();
