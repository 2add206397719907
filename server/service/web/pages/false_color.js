// Luminance as colours, with a legend: the map cividis, which looks alike with and without colour-vision
// deficiency [Nunez2018].
"use strict";

/// Colours at even places (client/plot/color_map.cpp).
const kCividisKnots = [
  0, 34, 78, 0, 40, 91, 0, 46, 106, 4, 51, 113, 26, 56, 111, 39, 62, 110, 50, 67, 109, 59, 73, 108, 67,
  78, 108, 75, 84, 108, 82, 89, 109, 90, 95, 110, 97, 101, 111, 104, 106, 113, 111, 112, 115, 117, 118,
  118, 124, 123, 120, 132, 129, 121, 139, 135, 120, 147, 141, 120, 155, 147, 118, 163, 154, 117, 171,
  160, 114, 179, 166, 112, 187, 173, 108, 195, 180, 105, 204, 186, 100, 212, 193, 95, 221, 201, 88, 230,
  208, 81, 239, 215, 72, 248, 223, 60, 254, 232, 56,
];
const kMostDecades = 6;

/// Bytes of 256 colours.
const kCividis = (() => {
  const table = new Uint8ClampedArray(256 * 3), last = kCividisKnots.length / 3 - 1;
  for (let i = 0; i < 256; ++i) {
    const at = i / 255 * last, knot = Math.min(Math.floor(at), last - 1);
    for (let band = 0; band < 3; ++band) {
      const from = kCividisKnots[3 * knot + band], to = kCividisKnots[3 * knot + 3 + band];
      table[3 * i + band] = from + (at - knot) * (to - from);
    }
  }
  return table;
})();

/// Numbers of all 16-bit floats, by their bits.
const kHalves = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; ++bits) table[bits] = fromHalf(bits);
  return table;
})();

/// 1, 2 or 5 times a power of ten, at least as large; or, downwards, at most.
function roundEnd(value, up) {
  const power = 10 ** Math.floor(Math.log10(value)), digit = value / power;
  if (up) return (digit <= 1 ? 1 : digit <= 2 ? 2 : digit <= 5 ? 5 : 10) * power;
  return (digit >= 5 ? 5 : digit >= 2 ? 2 : 1) * power;
}

/// What red, green and blue count: a sensor's own have no luminance, and are shown as if in Rec.709.
const kUsualWeights = [0.2126, 0.7152, 0.0722];
const tellsLuminance = (units) => units.weights.some((weight) => weight !== 0);
const weightsOf = (units) => tellsLuminance(units) ? units.weights : kUsualWeights;
function unitOf(units) {
  if (units.cd_per_m2) return "cd/m\u00b2";
  return tellsLuminance(units) ? "Y of the pixels" : "R, G, B weighted";
}
const lightOf = (data, at, weights) =>
  weights[0] * kHalves[data[at]] + weights[1] * kHalves[data[at + 1]] + weights[2] * kHalves[data[at + 2]];

/// A scale of luminances: `low` to `high`, in the numbers of pixels times their weights.
class LightScale {
  constructor(log, low, high) { Object.assign(this, { log, low, high }); }
  get key() { return [this.log, this.low, this.high].join(); }

  place(value) {
    if (!this.log) return (value - this.low) / (this.high - this.low);
    return value > 0 ? Math.log(value / this.low) / Math.log(this.high / this.low) : 0;
  }

  /// Round values, for a legend in units of which a number has `factor`.
  ticks(factor) {
    const low = this.low * factor, high = this.high * factor, ticks = [];
    if (this.log) {
      const few = Math.log10(high / low) <= 3;
      for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1e-9; ++power) {
        for (const digit of few ? [1, 2, 5] : [1]) {
          const value = digit * 10 ** power;
          if (value >= low * (1 - 1e-9) && value <= high * (1 + 1e-9)) ticks.push(value);
        }
      }
    } else {
      const step = roundEnd((high - low) / 6, true);
      for (let i = Math.ceil(low / step - 1e-6); i * step <= high * (1 + 1e-9); ++i) ticks.push(i * step);
    }
    return ticks;
  }
}

/// The scale that shows a picture of these 16-bit floats: round ends in units of which a number has `factor`,
/// without the brightest thousandth; from 0 on, or over six decades at most. `exposure` moves the ends, in
/// stops.
function lightScale(data, weights, factor, log, exposure) {
  const values = [];
  for (let at = 0; at < data.length; at += 4) {
    const light = lightOf(data, at, weights);
    if (data[at + 3] && light > 0 && light < Infinity) values.push(light);
  }
  values.sort((a, b) => a - b);
  if (!values.length) return new LightScale(log, log ? 0.001 : 0, 1);
  const end = (share, up) =>
    roundEnd(values[Math.floor(share * (values.length - 1))] * factor, up) * 2 ** -exposure / factor;
  const high = end(0.999, true);
  if (!log) return new LightScale(false, 0, high);
  const least = end(0.01, false);
  return new LightScale(true, Math.max(Math.min(least, high / 10), high * 10 ** -kMostDecades), high);
}

/// The legend over the picture.
class Legend {
  constructor(figure) { this.figure = figure; this.key = ""; }

  hide() { this.figure.hidden = true; this.key = ""; }

  show(scale, units) {
    const factor = units.cd_per_m2 || 1, key = scale.key + " " + factor;
    if (key === this.key) return;
    this.key = key;
    const caption = element("figcaption", unitOf(units));
    caption.title = units.about;
    this.figure.replaceChildren(caption, this.bar(scale, factor));
    this.figure.hidden = false;
  }

  bar(scale, factor) {
    const height = 180, image = drawing("svg", { viewBox: "0 0 86 " + (height + 14), role: "img" });
    const range = "From " + digits(scale.low * factor) + " to " + digits(scale.high * factor);
    image.append(drawing("title", {}, range));
    for (let i = 0; i < height; ++i) {
      const color = 3 * Math.round(255 * (1 - (i + 0.5) / height));
      const fill = "rgb(" + kCividis[color] + " " + kCividis[color + 1] + " " + kCividis[color + 2] + ")";
      image.append(drawing("rect", { x: 0, y: i + 7, width: 14, height: 1.2, fill }));
    }
    for (const value of scale.ticks(factor)) {
      const y = 7 + height * (1 - scale.place(value / factor));
      const label = value.toLocaleString("en", { maximumSignificantDigits: 6 });
      image.append(drawing("path", { d: "M14 " + y.toFixed(1) + "h4", class: "axis" }),
        drawing("text", { x: 21, y: (y + 4).toFixed(1) }, label));
    }
    return image;
  }
}
