/** Whether this page is a demo: a static folder whose files stand in for a server. */

const mark =
  typeof document === 'undefined'
    ? null
    : document.querySelector<HTMLMetaElement>('meta[name="motionlab-demo"]');

/** Address of the folder with its answers; null where a server answers. */
export const demo: string | null = mark ? new URL(mark.content, document.baseURI).href : null;

export const NEEDS_SERVER =
  'This needs a server, and a demo has none: pip install "motionlab[lab]", then motionlab serve.';
export const IN_PAGE =
  'This page computes it; a server finds the same to within a few counts of the encoder';
/** Screens that a demo has. */
export const DEMO_SCREENS: readonly string[] = ['lab', 'trajectories'];
