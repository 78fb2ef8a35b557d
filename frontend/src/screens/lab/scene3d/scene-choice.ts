/** What the 3-D view shows, as text: `section.B.y.ghost.true-size.-load`. */

export const CAMERAS = ['overview', 'top', 'side', 'section', 'follow'] as const;
export const ARROWS = ['thrust', 'phases', 'normal', 'friction', 'load'] as const;
export type Camera = (typeof CAMERAS)[number];
export type Arrow = (typeof ARROWS)[number];

export interface SceneChoice {
  camera: Camera;
  machine: string;
  axis: 'x' | 'y';
  ghost: boolean;
  /** Errors as large as on the plane, or as they are. */
  magnified: boolean;
  arrows: readonly Arrow[];
  /** The view fills the page below the top bar. */
  filled: boolean;
  numbers: boolean;
}

export const USUAL: SceneChoice = {
  camera: 'overview',
  machine: 'A',
  axis: 'x',
  ghost: false,
  magnified: true,
  arrows: ARROWS,
  filled: false,
  numbers: true,
};

export function written(choice: SceneChoice): string {
  const { camera, machine, axis, ghost, magnified, arrows, filled, numbers } = choice;
  return [
    camera,
    machine,
    axis,
    ...(ghost ? ['ghost'] : []),
    ...(magnified ? [] : ['true-size']),
    ...(filled ? ['filled'] : []),
    ...(numbers ? [] : ['bare']),
    ...ARROWS.filter((arrow) => !arrows.includes(arrow)).map((arrow) => `-${arrow}`),
  ].join('.');
}

/** Reads what `written` writes; what is missing or unknown is as usual. */
export function read(text: string): SceneChoice {
  const words = text.split('.');
  const has = (word: string) => words.includes(word);
  return {
    camera: CAMERAS.find(has) ?? USUAL.camera,
    machine: words.find((word) => /^[A-Z]$/.test(word)) ?? USUAL.machine,
    axis: has('y') ? 'y' : 'x',
    ghost: has('ghost'),
    magnified: !has('true-size'),
    arrows: ARROWS.filter((arrow) => !has(`-${arrow}`)),
    filled: has('filled'),
    numbers: !has('bare'),
  };
}
