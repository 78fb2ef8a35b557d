/** How a response is measured: with which signal, force and time. */

import type { Value } from '../../app/api/types';
import { StudyForm } from '../../study/study-form.svelte';

type Request = Readonly<Record<string, unknown>>;

/** What a person enters; the rest of a request is the loop that is measured. */
export const FIELDS = ['signal', 'force', 'seconds'] as const;

/**
 * Time of stepped sines unless another is entered, s: two slides of each of the 48 sines between
 * 1 and 700 Hz, of 5.7 s at most, on any motor.
 */
export const STEPPED = 600;

export class ResponseForm extends StudyForm {
  readonly stepped = $derived.by(() => this.text('signal') === 'stepped-sine');

  constructor() {
    super('response');
  }

  protected override usual(path: string): Value {
    return path === 'seconds' && this.stepped ? STEPPED : super.usual(path);
  }

  override body(): Record<string, unknown> {
    return { ...(this.stepped ? { seconds: STEPPED } : {}), ...super.body() };
  }

  override restore(request: Request): void {
    // The signal first: the usual time is that of the signal.
    const { signal = null } = request;
    super.restore({ signal });
    super.restore(Object.fromEntries(FIELDS.map((name) => [name, request[name]])));
  }

  /** Names of the settings in which the form is another than a request. */
  others(request: Request | undefined): readonly string[] {
    const own = Object.fromEntries(FIELDS.map((name) => [name, this.value(name)]));
    return this.differing(request, { ...request, ...own });
  }
}
