import { expect, it, vi } from 'vitest';

vi.stubGlobal('location', { href: 'http://lab.test/' });
const { SCREENS } = await import('../app/screen.svelte');

it('has one component for each screen of the menu, and a menu entry for each component', () => {
  const components = Object.keys(import.meta.glob('./*/*Screen.svelte'));
  const folders = components.map((path) => path.split('/')[1] ?? '');
  const loaded = SCREENS.map(({ screen }) => screen).filter((screen) => screen !== 'lab');
  expect(new Set(folders)).toEqual(new Set(loaded));
  expect(folders).toHaveLength(loaded.length);
});
