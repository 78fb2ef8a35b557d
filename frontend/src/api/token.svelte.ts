/** The server's token: asked for once, while the requests that need it wait. */

import type { Api } from './client';

export class TokenPrompt {
  wanted = $state(false);
  private waiting: (() => void)[] = [];

  constructor(private readonly api: Api) {
    api.onUnauthorized = () =>
      new Promise((resolve) => {
        this.wanted = true;
        this.waiting.push(resolve);
      });
  }

  async give(token: string): Promise<void> {
    await this.api.login(token);
    this.wanted = false;
    this.waiting.forEach((go) => go());
    this.waiting = [];
  }
}
