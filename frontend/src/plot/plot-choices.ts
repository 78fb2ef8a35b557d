/** The menu of a plot: save or copy its picture and its numbers. */

import { mount, unmount } from 'svelte';
import { copyText, saveFile } from '../ui/export';
import type { ShownPlot } from './plot-menu';
import Menu from './PlotMenu.svelte';
import { csvOf, tableOf, tabbed } from './table-file';
import { pictureOf, pngOf } from './plot-export';

export interface Choice {
  name: string;
  /** What is said once it is done; nothing of a file, which the browser shows. */
  done?: string;
  run: () => Promise<void>;
}

/** Opens the menu where the pointer is, or at the plot. */
export function open(plot: ShownPlot, event: MouseEvent): void {
  const back = document.activeElement as HTMLElement | null;
  const box = plot.canvas.element.getBoundingClientRect();
  const pointed = event.clientX > 0 || event.clientY > 0;
  const [x, y] = pointed ? [event.clientX, event.clientY] : [box.left + 24, box.top + 24];
  const menu = mount(Menu, {
    target: document.body,
    props: {
      x,
      y,
      choices: choicesOf(plot),
      close: () => {
        void unmount(menu);
        back?.focus();
      },
    },
  });
}

function choicesOf(plot: ShownPlot): Choice[] {
  const { data } = plot;
  const name = async () => {
    const picture = await pictureOf(plot);
    const ascii = picture.title.replace(/[µμ]/g, 'u'); // without it, µm would read as m
    return { picture, name: ascii.replace(/[^\w.-]+/g, '-').replace(/^-|-$/g, '') };
  };
  const title = () => {
    const around = plot.canvas.element.closest('figure, section');
    return (around?.getAttribute('aria-label') ?? 'plot').replace(/[^\w.-]+/g, '-');
  };
  const pictures: Choice[] = [
    {
      name: 'Save as PNG',
      run: async () => {
        const made = await name();
        saveFile(`${made.name}.png`, 'image/png', await pngOf(made.picture));
      },
    },
    {
      name: 'Save as SVG',
      run: async () => {
        const made = await name();
        saveFile(`${made.name}.svg`, 'image/svg+xml', made.picture.svg);
      },
    },
    {
      name: 'Copy picture',
      done: 'Copied',
      run: async () => {
        const made = await name();
        const item = new ClipboardItem({ 'image/png': await pngOf(made.picture) });
        await navigator.clipboard.write([item]);
      },
    },
  ];
  if (!data) return pictures;
  return [
    ...pictures,
    {
      name: 'Save numbers as CSV',
      run: async () => saveFile(`${title()}.csv`, 'text/csv', csvOf(tableOf(data()))),
    },
    {
      name: 'Copy numbers',
      done: 'Copied',
      run: () => copyText(tabbed(tableOf(data()))),
    },
  ];
}
