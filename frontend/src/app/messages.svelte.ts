/** Notices, which go by themselves, and errors, which stay until they are dismissed. */

/** An action on a message, which dismisses it. */
export interface Action {
  name: string;
  run: () => void;
}

export interface Message {
  id: number;
  kind: 'error' | 'info';
  text: string;
  actions: readonly Action[];
  /** Whether it stays until it is dismissed. */
  stays: boolean;
}

/** A notice stays for as long as it takes to read it, ms, and no less than this. */
const LEAST = 5000;
const A_CHARACTER = 60;
/** One that can be acted on stays longer, ms. */
const TO_DECIDE = 12_000;

class Messages {
  /** Oldest first. */
  list = $state.raw<readonly Message[]>([]);
  private last = 0;
  private held = false;
  private readonly timers = new Map<number, ReturnType<typeof setTimeout>>();

  error(text: string): void {
    this.add({ kind: 'error', text, actions: [], stays: true });
  }

  /** Shows a notice; one that matters after an absence `stays`. */
  info(text: string, actions: readonly Action[] = [], { stays = false } = {}): void {
    this.add({ kind: 'info', text, actions, stays });
  }

  /** Dismisses what no longer holds. */
  withdraw(text: string): void {
    const message = this.list.find((each) => each.text === text);
    if (message) this.dismiss(message.id);
  }

  dismiss(id: number): void {
    clearTimeout(this.timers.get(id));
    this.timers.delete(id);
    this.list = this.list.filter((message) => message.id !== id);
    // A removed element fires no event when pointer or focus leave it.
    if (this.list.length === 0) this.held = false;
  }

  act(id: number, action: Action): void {
    this.dismiss(id);
    action.run();
  }

  /** Keeps notices while the pointer or the focus is on them. */
  hold(held: boolean): void {
    this.held = held;
    for (const message of this.list) this.time(message);
  }

  private add(content: Omit<Message, 'id'>): void {
    // The same again replaces what it repeats.
    const same = this.list.find(({ text }) => text === content.text);
    if (same) this.dismiss(same.id);
    this.last += 1;
    const message = { id: this.last, ...content };
    this.list = [...this.list, message];
    this.time(message);
  }

  private time({ id, text, actions, stays }: Message): void {
    clearTimeout(this.timers.get(id));
    if (stays || this.held) return;
    const stay = Math.max(actions.length > 0 ? TO_DECIDE : LEAST, A_CHARACTER * text.length);
    this.timers.set(
      id,
      setTimeout(() => this.dismiss(id), stay),
    );
  }
}

export const messages = new Messages();
