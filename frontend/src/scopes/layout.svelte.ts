/** Which scopes are shown with which channels, and what a person does to them. */

import {
  layoutText,
  moved,
  readLayout,
  readScope,
  resized,
  scopeWith,
  SCOPES_MAX,
  TRACES_MAX,
  type ScopeSpec,
} from '../plot/scope-layout';
import { fromAddress, load, save, setAddress } from '../app/storage';

interface Place {
  /** Where the browser keeps it. */
  key: string;
  /** Whether the address has it too. */
  linked?: boolean;
  /** The scopes of a layout that ships, by its name, or of the usual one. */
  shipped: (name: string) => readonly ScopeSpec[];
}

interface Kept {
  name: string;
  scopes: string;
  /** Places of the open scopes: `0,2`. */
  open?: unknown;
}

export class Layout {
  /** Of the one that it began as; empty for the usual one. */
  name = $state('');
  /** Places of the scopes that are drawn in full; the others are strips. */
  open = $state.raw<readonly number[]>([0]);
  /** The scope that channels are being chosen for; null while none are, its end for a new scope. */
  choosing = $state<number | null>(null);
  /** Lists of channels that are there to choose from. */
  lists = 0;
  /** What is typed for such a list while it is being loaded; a line ends where Enter was pressed. */
  early = '';
  /** What was changed; null while it is as it ships. */
  private own = $state.raw<readonly ScopeSpec[] | null>(null);

  constructor(private readonly place: Place) {
    const { key, linked = false } = place;
    const kept = load<Kept>(key, { name: '', scopes: '' });
    const address = linked ? fromAddress('scopes') : null;
    this.own = readLayout(address ?? kept.scopes);
    this.name = address === null ? kept.name : (fromAddress('layout') ?? '');
    this.open = openOf((linked ? fromAddress('open') : null) ?? kept.open);
  }

  get scopes(): readonly ScopeSpec[] {
    return this.own ?? this.place.shipped(this.name);
  }

  /** Whether it is no longer what its name says. */
  get changed(): boolean {
    return this.own !== null;
  }

  get full(): boolean {
    return this.scopes.length >= SCOPES_MAX;
  }

  get text(): string {
    return layoutText(this.scopes);
  }

  /** What an address says of it: `scopes` empty for those of its name, `open` for the first alone. */
  get parameters(): { scopes: string; layout: string; open: string } {
    const { own, name, open } = this;
    const places = open.join() === '0' ? '' : open.join();
    return { scopes: own ? layoutText(own) : '', layout: name, open: places };
  }

  /** Takes what an address says, which this browser does not keep until it is changed. */
  readParameters({ scopes, layout, open }: Record<'scopes' | 'layout' | 'open', unknown>): void {
    this.own = readLayout(String(scopes ?? ''));
    this.name = String(layout ?? '');
    this.open = openOf(open);
  }

  /** Takes a layout that ships, by its name, or one that is kept: its scopes, one text each. */
  take(name: string, scopes: readonly string[] | null = null): void {
    const read = scopes?.map(readScope).filter((scope) => scope !== null) ?? null;
    this.open = [0];
    this.name = name;
    this.put(read?.length ? read : null);
  }

  /** Changes every scope. */
  map(change: (spec: ScopeSpec) => ScopeSpec): void {
    if (this.own) this.put(this.own.map(change));
  }

  addChannel(place: number, channel: string): void {
    if (place >= this.scopes.length) this.add(channel);
    else {
      this.change(place, (spec) =>
        spec.channels.includes(channel) || spec.channels.length >= TRACES_MAX
          ? spec
          : { ...spec, channels: [...spec.channels, channel], hold: null },
      );
    }
  }

  add(...channels: string[]): void {
    if (this.full) return;
    const place = this.scopes.length;
    this.open = this.open.length > 1 ? [...this.open, place] : [place];
    this.put([...this.scopes, scopeWith(...channels)]);
  }

  /** Takes a channel from a scope; the last one takes its scope with it. */
  removeChannel(place: number, channel: string): void {
    if ((this.scopes[place]?.channels.length ?? 0) < 2) return this.remove(place);
    const without = (names: readonly string[]) => names.filter((name) => name !== channel);
    this.change(place, ({ channels, hidden, own, ...rest }) => ({
      ...rest,
      channels: without(channels),
      hidden: without(hidden),
      own: without(own),
    }));
  }

  /** Replaces a channel by another wherever it is shown. */
  replaceChannel(channel: string, other: string): void {
    const swap = (names: readonly string[]) =>
      names
        .map((name) => (name === channel ? other : name))
        .filter((name, i, all) => all.indexOf(name) === i);
    this.put(
      this.scopes.map((spec) =>
        spec.channels.includes(channel)
          ? {
              ...spec,
              channels: swap(spec.channels),
              hidden: swap(spec.hidden),
              own: swap(spec.own),
              hold: null,
            }
          : spec,
      ),
    );
  }

  /** Takes a channel from all scopes; one that shows nothing else goes with it, but the last. */
  dropChannel(channel: string): void {
    for (let place = this.scopes.length - 1; place >= 0; place--) {
      if (this.scopes[place]?.channels.includes(channel)) this.removeChannel(place, channel);
    }
  }

  remove(place: number): void {
    if (this.scopes.length < 2) return;
    this.rearrange(this.scopes.map((_, i) => i).filter((i) => i !== place));
  }

  move(place: number, to: number): void {
    this.rearrange(
      moved(
        this.scopes.map((_, i) => i),
        place,
        to,
      ),
    );
  }

  /** Puts the scopes of these places one after the other; those that were open stay so. */
  private rearrange(places: readonly number[]): void {
    const { scopes, open } = this;
    const next = places.flatMap((place) => scopes[place] ?? []);
    const opened = places.flatMap((place, i) => (open.includes(place) ? [i] : []));
    this.open = opened.length > 0 ? opened : [0];
    this.put(next);
  }

  /** Shows or hides a trace. */
  toggle(place: number, channel: string): void {
    this.change(place, (spec) => ({ ...spec, hidden: toggled(spec.hidden, channel) }));
  }

  /** Shows a trace alone, or all again. */
  solo(place: number, channel: string): void {
    this.change(place, (spec) => {
      const others = spec.channels.filter((each) => each !== channel);
      const alone = others.every((each) => spec.hidden.includes(each));
      return { ...spec, hidden: alone ? [] : others };
    });
  }

  /** Gives a trace a value axis of its own, or takes it away. */
  toggleOwn(place: number, channel: string): void {
    this.change(place, (spec) => ({ ...spec, own: toggled(spec.own, channel) }));
  }

  hold(place: number, hold: readonly [number, number] | null): void {
    this.change(place, (spec) => ({ ...spec, hold }));
  }

  /** Whether a value axis is held. */
  get holds(): boolean {
    return this.scopes.some(({ hold }) => hold !== null);
  }

  /** Has all value axes follow the data again. */
  release(): void {
    if (this.holds) this.put(this.scopes.map((spec) => ({ ...spec, hold: null })));
  }

  /** Brings one scope forward: it alone is drawn in full. */
  forward(place: number): void {
    if (place < this.scopes.length) this.setOpen([place]);
  }

  /** Draws a scope in full beside those that are, or folds it to a strip again. */
  toggleOpen(place: number): void {
    const { open } = this;
    if (!open.includes(place)) this.setOpen([...open, place].sort((a, b) => a - b));
    else if (open.length > 1) this.setOpen(open.filter((each) => each !== place));
  }

  private setOpen(open: readonly number[]): void {
    this.open = open;
    this.keep();
  }

  /** Moves the line between two open scopes by a share of both. */
  resize(place: number, next: number, share: number): void {
    const [above, below] = [this.scopes[place], this.scopes[next]];
    if (!above || !below) return;
    const [first, second] = resized(above.size, below.size, share);
    const sizes: Record<number, number> = { [place]: first, [next]: second };
    this.put(this.scopes.map((spec, i) => ({ ...spec, size: sizes[i] ?? spec.size })));
  }

  private change(place: number, change: (spec: ScopeSpec) => ScopeSpec): void {
    this.put(this.scopes.map((spec, i) => (i === place ? change(spec) : spec)));
  }

  private put(scopes: readonly ScopeSpec[] | null): void {
    this.own = scopes;
    this.keep();
  }

  private keep(): void {
    const { place, parameters } = this;
    const { layout: name, scopes, open } = parameters;
    save(place.key, { name, scopes, open });
    if (place.linked) setAddress(parameters);
  }
}

/** Reads the places of open scopes; the first one where there are none. */
function openOf(text: unknown): readonly number[] {
  const places = /^\d{1,2}(,\d{1,2})*$/.test(String(text))
    ? String(text).split(',').map(Number)
    : [0];
  return [...new Set(places)].sort((a, b) => a - b);
}

function toggled(names: readonly string[], name: string): string[] {
  const rest = names.filter((each) => each !== name);
  return rest.length < names.length ? rest : [...rest, name];
}
