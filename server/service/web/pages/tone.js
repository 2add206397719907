// Values to bytes of a screen: tone curves for colours, a scale of colours for numbers.
"use strict";

/// The look of a 16-bit float: byte by its bits.
class Tone {
  constructor() { this.table = new Uint8ClampedArray(65536); this.key = ""; }
  set(exposure, curve) {
    const key = exposure + " " + curve;
    if (key === this.key) return false;
    this.key = key;
    const scale = 2 ** exposure;
    for (let bits = 0; bits < 65536; ++bits) {
      let value = Math.max(0, fromHalf(bits) * scale);
      if (!(value < Infinity)) value = Number.isNaN(value) ? 0 : 1e9;
      // Filmic: the fit of [Narkowicz 2015] to the ACES curve.
      if (curve === 1)
        value = value > 1e4 ? 1 : value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14);
      if (curve !== 2) value = value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055;
      this.table[bits] = 255 * value + 0.5;
    }
    return true;
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
