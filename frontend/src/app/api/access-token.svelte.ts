/** The server's token: entered once, while the requests that need it wait. */

import type { Api } from './client';

export class TokenPrompt {
  needed = $state(false);
  /** Whether this server has browsers log in at all. */
  required = $state(false);
  private waiting: (() => void)[] = [];

  constructor(private readonly api: Api) {
    api.onUnauthorized = () =>
      new Promise((resolve) => {
        this.needed = true;
        this.waiting.push(resolve);
      });
  }

  async give(token: string): Promise<void> {
    await this.api.login(token);
    this.needed = false;
    this.waiting.forEach((go) => go());
    this.waiting = [];
  }

  /** Ends the log-in; the page, loaded anew, asks for the token. */
  async end(): Promise<void> {
    await this.api.logout();
    location.reload();
  }
}
