import { expect, it } from 'vitest';
import { textOf } from './file-text';

it.each([
  ['UTF-8', [0x47, 0xc3, 0xb6]],
  ['UTF-8 with its mark', [0xef, 0xbb, 0xbf, 0x47, 0xc3, 0xb6]],
  ['Windows-1252', [0x47, 0xf6]],
  ['UTF-16, little-endian', [0xff, 0xfe, 0x47, 0, 0xf6, 0]],
  ['UTF-16, big-endian', [0xfe, 0xff, 0, 0x47, 0, 0xf6]],
  ['UTF-16 without its mark', [0x47, 0, 0xf6, 0]],
])('a text in %s is shown', async (_, bytes) => {
  expect(await textOf(new Blob([new Uint8Array(bytes)]))).toBe('Gö');
});
