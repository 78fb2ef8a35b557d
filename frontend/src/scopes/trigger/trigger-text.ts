/** What triggered, in words and SI: the note of a capture that is kept. */

import type { Condition } from './detector';
import type { Settings } from './trigger.svelte';

export function triggerText({ conditions, join }: Pick<Settings, 'conditions' | 'join'>): string {
  return `Trigger: ${conditions.map(conditionText).join(` ${join} `)}.`;
}

function conditionText(condition: Condition): string {
  switch (condition.kind) {
    case 'reversal':
      return `reversal of ${condition.channel}${condition.slope === 'either' ? '' : `, ${condition.slope}`}`;
    case 'level': {
      const { channel, slope, level, hysteresis } = condition;
      const way = { rising: 'rises to', falling: 'falls to', either: 'passes' }[slope];
      return `${channel} ${way} ${level}, hysteresis ${hysteresis}`;
    }
    case 'window': {
      const { channel, way, low, high, hysteresis } = condition;
      return `${channel} ${way} ${low} to ${high}, hysteresis ${hysteresis}`;
    }
    case 'mark':
      return 'any mark';
  }
}
