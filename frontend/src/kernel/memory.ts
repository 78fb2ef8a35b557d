/** The module's memory, laid out from the bottom up. */

const PAGE = 65_536;
const ALIGNMENT = 16;
/** Nothing lies at pointer 0. */
const BOTTOM = 64;

/** A worker's memory is full: the run is too large for this page. */
export class MemoryFull extends Error {
  constructor(bytes: number, most: number) {
    super(`the run takes ${(bytes / 1e6).toFixed(0)} MB, more than ${(most / 1e6).toFixed(0)} MB`);
  }
}

export class Memory {
  readonly memory: WebAssembly.Memory;
  /** First byte that is free. */
  private top = BOTTOM;

  constructor(private readonly most: number) {
    this.memory = new WebAssembly.Memory({ initial: 1, maximum: Math.ceil(most / PAGE) });
  }

  get bytes(): number {
    return this.memory.buffer.byteLength;
  }

  /** Frees what was placed after a mark. */
  get mark(): number {
    return this.top;
  }
  release(mark = BOTTOM): void {
    this.top = mark;
  }

  /** Returns the pointer to so many bytes; growing makes all views invalid. */
  place(bytes: number): number {
    const pointer = this.top;
    const end = Math.ceil((pointer + bytes) / ALIGNMENT) * ALIGNMENT;
    if (end > this.most) throw new MemoryFull(end, this.most);
    if (end > this.bytes) this.memory.grow(Math.ceil((end - this.bytes) / PAGE));
    this.top = end;
    return pointer;
  }

  float64(pointer: number, count: number): Float64Array {
    return new Float64Array(this.memory.buffer, pointer, count);
  }

  float32(pointer: number, count: number): Float32Array {
    return new Float32Array(this.memory.buffer, pointer, count);
  }

  /** Returns the pointer to a copy of some numbers. */
  put(values: Float64Array): number {
    const pointer = this.place(values.byteLength);
    this.float64(pointer, values.length).set(values);
    return pointer;
  }
}
