// Values to bytes of a screen: tone curves for colours, a scale of colours for numbers.
"use strict";

/// The sRGB code, from 0 to 1, of a linear value.
function srgbCode(value) {
  if (!(value > 0)) return 0;
  return value >= 1 ? 1 : value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
}

/// Half of the sigmoid of AgX, on one side of its pivot (client/image/view/display_view.cpp, as all of kMixes).
function halfSigmoid(distance, length, power) {
  const slope = 2, height = 0.5;
  const scale = slope * length / ((slope * length / height) ** power - 1) ** (1 / power);
  const along = slope * distance / scale;
  return scale * along / (1 + along ** power) ** (1 / power);
}

/// Looks in which red, green and blue depend on each other: matrices before and after a curve, by their numbers
/// in the list of the page.
const kMixes = {
  3: {
    before: [0.59719, 0.35458, 0.04823, 0.07600, 0.90834, 0.01566, 0.02840, 0.13383, 0.83777],
    curve: (x) => (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081),
    after: [1.60475, -0.53108, -0.07367, -0.10208, 1.10813, -0.00605, -0.00327, -0.07276, 1.07602],
    code: srgbCode,
  },
  4: {
    before: [0.842479062253094, 0.0784335999999992, 0.0792237451477643, 0.0423282422610123, 0.878468636469772,
      0.0791661274605434, 0.0423756549057051, 0.0784336, 0.879142973793104],
    curve: (x) => {
      const pivot = 10 / 16.5;
      const place = Math.min(1, Math.max(0, (Math.log2(Math.max(x, 1e-10) / 0.18) + 10) / 16.5));
      return place < pivot ? 0.5 - halfSigmoid(pivot - place, pivot, 3)
        : 0.5 + halfSigmoid(place - pivot, 1 - pivot, 3.25);
    },
    after: [1.196879, -0.098021, -0.09903, -0.052897, 1.151903, -0.098961, -0.052972, -0.098043, 1.151074],
    code: (x) => srgbCode(Math.min(1, Math.max(0, x)) ** 2.2),
  },
};

/// The look of a 16-bit float: byte by its bits; clamped arrays round. Looks of kMixes have `mix`, too, for whole colours.
class Tone {
  constructor() { this.table = new Uint8ClampedArray(65536); this.key = ""; this.mix = null; }
  set(exposure, curve) {
    const key = exposure + " " + curve;
    if (key === this.key) return false;
    this.key = key;
    const scale = 2 ** exposure;
    this.mix = kMixes[curve] ? this.mixed(kMixes[curve], scale) : null;
    for (let bits = 0; bits < 65536; ++bits) {
      let value = Math.max(0, fromHalf(bits) * scale);
      if (!(value < Infinity)) value = Number.isNaN(value) ? 0 : 1e9;
      if (this.mix) {
        this.table[bits] = 255 * this.mix(bits, bits, bits)[1];
        continue;
      }
      // Filmic: the fit of [Narkowicz 2015] to the ACES curve.
      if (curve === 1)
        value = value > 1e4 ? 1 : value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14);
      this.table[bits] = 255 * (curve === 2 ? value : srgbCode(value));
    }
    return true;
  }

  /// Codes, from 0 to 1, of a colour of three 16-bit floats by their bits.
  mixed({ before, curve, after, code }, scale) {
    const light = [0, 0, 0], curved = [0, 0, 0], codes = [0, 0, 0];
    const row = (matrix, band, v) => matrix[3 * band] * v[0] + matrix[3 * band + 1] * v[1] + matrix[3 * band + 2] * v[2];
    return (...bits) => {
      for (let band = 0; band < 3; ++band) {
        const value = fromHalf(bits[band]) * scale;
        light[band] = value > 0 ? Math.min(value, 65504) : 0;
      }
      for (let band = 0; band < 3; ++band) curved[band] = curve(row(before, band, light));
      for (let band = 0; band < 3; ++band) codes[band] = code(row(after, band, curved));
      return codes;
    };
  }
}

/// Black, violet, orange, yellow, white: brighter is more, also without colours.
const kHeat = (() => {
  const stops = [[0, 0, 4], [60, 15, 110], [140, 41, 129], [222, 73, 104], [254, 159, 109], [252, 253, 191]];
  const table = new Uint8Array(256 * 3);
  for (let i = 0; i < 256; ++i) {
    const t = i / 255 * (stops.length - 1), k = Math.min(Math.floor(t), stops.length - 2);
    for (let band = 0; band < 3; ++band)
      table[3 * i + band] = stops[k][band] + (t - k) * (stops[k + 1][band] - stops[k][band]);
  }
  return table;
})();
