/** The Fourier transform of real samples, of any number of them. */

/**
 * Returns |X_k|^2 of bins 0 to n/2.
 *
 * Bluestein 1970 (doi 10.1109/TAU.1970.1162132): k m = (k^2 + m^2 - (k - m)^2)/2 makes the transform a
 * convolution, which transforms of a power of two compute.
 */
export class PowerTransform {
  private readonly size: number;
  private readonly cosine: Float64Array;
  private readonly sine: Float64Array;
  private readonly chirp: [Float64Array, Float64Array];

  constructor(private readonly count: number) {
    this.size = 2 ** Math.ceil(Math.log2(2 * count));
    const { size } = this;
    const angle = (k: number) => (Math.PI * ((k * k) % (2 * count))) / count;
    this.cosine = Float64Array.from({ length: count }, (_, k) => Math.cos(angle(k)));
    this.sine = Float64Array.from({ length: count }, (_, k) => Math.sin(angle(k)));
    const [real, imaginary] = [new Float64Array(size), new Float64Array(size)];
    for (let k = 0; k < count; k++) {
      real[k] = real[(size - k) % size] = this.cosine[k] as number;
      imaginary[k] = imaginary[(size - k) % size] = this.sine[k] as number;
    }
    transform(real, imaginary);
    this.chirp = [real, imaginary];
  }

  of(values: Float64Array): Float64Array {
    const { size, count, cosine, sine } = this;
    const [re, im] = [new Float64Array(size), new Float64Array(size)];
    values.forEach((value, k) => {
      re[k] = value * (cosine[k] as number);
      im[k] = -value * (sine[k] as number);
    });
    transform(re, im);
    const [a, b] = this.chirp;
    for (let k = 0; k < size; k++) {
      const [x, y, c, d] = [re[k], im[k], a[k], b[k]] as [number, number, number, number];
      re[k] = x * c - y * d;
      im[k] = -(x * d + y * c); // conjugate: transformed once more, it is the inverse
    }
    transform(re, im);
    // The chirp behind it turns a bin, and leaves its length.
    return Float64Array.from(
      { length: Math.floor(count / 2) + 1 },
      (_, k) => ((re[k] as number) ** 2 + (im[k] as number) ** 2) / size ** 2,
    );
  }
}

/** Transforms in place; the length is a power of two (Cooley and Tukey 1965). */
function transform(re: Float64Array, im: Float64Array): void {
  const size = re.length;
  for (let i = 1, j = 0; i < size; i++) {
    let bit = size >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j] as number, re[i] as number];
      [im[i], im[j]] = [im[j] as number, im[i] as number];
    }
  }
  const cosine = Float64Array.from({ length: size / 2 }, (_, k) =>
    Math.cos((2 * Math.PI * k) / size),
  );
  const sine = Float64Array.from(
    { length: size / 2 },
    (_, k) => -Math.sin((2 * Math.PI * k) / size),
  );
  for (let length = 2; length <= size; length *= 2) {
    const [half, step] = [length / 2, size / length];
    for (let first = 0; first < size; first += length) {
      for (let k = 0; k < half; k++) {
        const [i, j] = [first + k, first + k + half];
        const [c, s] = [cosine[k * step], sine[k * step]] as [number, number];
        const [x, y] = [re[j], im[j]] as [number, number];
        const [p, q] = [x * c - y * s, x * s + y * c];
        re[j] = (re[i] as number) - p;
        im[j] = (im[i] as number) - q;
        re[i] = (re[i] as number) + p;
        im[i] = (im[i] as number) + q;
      }
    }
  }
}
