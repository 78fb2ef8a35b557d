/** Messages that stay until they are dismissed. */

export interface Message {
  id: number;
  kind: 'error' | 'info';
  text: string;
}

class Messages {
  list = $state.raw<readonly Message[]>([]);
  private last = 0;

  error(text: string): void {
    this.add('error', text);
  }

  info(text: string): void {
    this.add('info', text);
  }

  dismiss(id: number): void {
    this.list = this.list.filter((message) => message.id !== id);
  }

  private add(kind: Message['kind'], text: string): void {
    // The same again says nothing new.
    if (this.list.some((message) => message.text === text)) return;
    this.last += 1;
    this.list = [...this.list, { id: this.last, kind, text }];
  }
}

export const messages = new Messages();
