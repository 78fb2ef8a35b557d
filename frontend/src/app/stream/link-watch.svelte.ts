/** Whether anything still comes from the server: a network that dies says so to no one. */

import { ageText } from '../../ui/units';

/** Missing data count after this time, ms: with the next look they are said within a second. */
const MISSING = 800;
/** Without news for this long while nothing moves, ms, the server is asked for a sign of life. */
const QUIET = 2000;
/** After this long, ms, a stream that is silent although the server answers is opened anew. */
const DEAD = 5000;
const LOOK = 200; // ms

export interface Watched {
  /** When the stream has last brought anything, ms; null before it has. */
  readonly heardAt: number | null;
  /** Whether data have to come without end: the session plays. */
  readonly moving: boolean;
  /** Asks the server for a sign of life; rejects where there is none. */
  ask(): Promise<unknown>;
  /** Opens the stream anew. */
  reconnect(): void;
}

/** A silence in words; at rest no data are due, but an answer is. */
export function silenceText(seconds: number, atRest = false): string {
  if (seconds === 0) return '';
  return `no ${atRest ? 'answer' : 'data'} since ${ageText(seconds)}`;
}

export class LinkWatch {
  /** Time without data, s; 0 while all is well. */
  silence = $state(0);
  private atRest = $state(false);
  /** The silence in words; empty while all is well. */
  readonly text = $derived(silenceText(this.silence, this.atRest));
  private movingSince: number | null = null;
  private answeredAt = 0;
  private asking = false;
  private reconnectedAt = 0;

  constructor(
    private readonly watched: Watched,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** Looks a few times a second until the returned function is called. */
  start(): () => void {
    const timer = setInterval(() => {
      // A hidden page has few looks: what it missed between two of them is no silence.
      if (document.hidden) this.answeredAt = this.now();
      else this.look();
    }, LOOK);
    return () => clearInterval(timer);
  }

  look(): void {
    const { heardAt, moving } = this.watched;
    const now = this.now();
    this.atRest = !moving;
    if (heardAt === null) {
      this.silence = 0;
      return;
    }
    this.movingSince = moving ? (this.movingSince ?? now) : null;
    const since = Math.max(heardAt, this.movingSince ?? this.answeredAt);
    const silent = now - since;
    // At rest the answer to a question counts, so the silence of one that is open is no fault yet.
    const most = moving ? MISSING : QUIET + MISSING;
    this.silence = silent > most ? silent / 1000 : 0;
    if (silent > QUIET || (moving && silent > MISSING)) void this.ask();
    const answers = this.answeredAt > now - QUIET - MISSING;
    if (moving && silent > DEAD && answers && now - this.reconnectedAt > DEAD) {
      this.reconnectedAt = now;
      this.watched.reconnect();
    }
  }

  private async ask(): Promise<void> {
    if (this.asking) return;
    this.asking = true;
    try {
      await this.watched.ask();
      this.answeredAt = this.now();
    } catch {
      // The silence is shown.
    } finally {
      this.asking = false;
    }
  }
}
