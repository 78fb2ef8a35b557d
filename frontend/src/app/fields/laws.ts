/** Names of the laws of friction compensation and of force sharing. */

export const LAWS = [
  { law: 'off', name: 'no compensation' },
  { law: 'lugre-observer', name: 'LuGre observer, K = 0' },
  { law: 'residual-k', name: 'K from the residual' },
  { law: 'canudas-de-wit', name: 'Canudas de Wit' },
  { law: 'reversed-k', name: 'K, sign reversed' },
  { law: 'published-k', name: 'K as published' },
] as const;

export const SHARINGS = [
  { law: 'least-norm', name: 'least norm' },
  { law: 'force-per-ampere', name: 'per ampere' },
  { law: 'sine', name: 'sine' },
  { law: 'cubic', name: 'cubic' },
] as const;

/** Laws in which one phase hands over to the next within `sharing.overlap`. */
export const HANDING_OVER: readonly string[] = ['sine', 'cubic'];
