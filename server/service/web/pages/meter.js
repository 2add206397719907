// A click is a meter: the light of a pixel and of the pixels around it, with its error.
"use strict";

const kMeterAgain = 400; // ms until the coordinator is asked again, which has not read all results

/// A value and its standard error with the digits that the error lets it have: "512.3 ± 0.8".
function withError(value, error) {
  if (!(error > 0) || !Number.isFinite(error)) return digits(value);
  const first = Math.floor(Math.log10(error));
  const place = error < 2.95 * 10 ** first ? first - 1 : first;
  const size = Math.max(Math.abs(value), error);
  if (size >= 1e7 || size < 1e-4) {
    const power = Math.floor(Math.log10(size)), unit = 10 ** power;
    const decimals = Math.min(15, Math.max(0, power - place));
    const told = [value, error].map((number) => (number / unit).toFixed(decimals));
    return "(" + told.join(" \u00b1 ") + ")e" + power;
  }
  if (place > 0) {
    const unit = 10 ** place;
    return Math.round(value / unit) * unit + " \u00b1 " + Math.round(error / unit) * unit;
  }
  return value.toFixed(Math.min(15, -place)) + " \u00b1 " + error.toFixed(Math.min(15, -place));
}

class MeterPanel {
  constructor(figure) { this.figure = figure; this.asked = 0; }

  hide() { ++this.asked; this.figure.hidden = true; }

  /// Asks for a pixel of the film and shows it, unless another is asked for in the meantime.
  async show(source, x, y) {
    const asked = ++this.asked;
    const where = new URLSearchParams({ job: source.job, x: x - source.x0, y: y - source.y0 });
    const found = await ask("meter?" + where).catch((error) => tell(error.message));
    if (!found || asked !== this.asked) return;
    this.figure.replaceChildren(element("figcaption", x + ", " + y), this.table(found), ...this.notes(found));
    this.figure.hidden = false;
    if (found.more) setTimeout(() => { if (asked === this.asked) this.show(source, x, y); }, kMeterAgain);
  }

  /// Columns for the pixel and the mean of the block, a line for each quantity.
  table({ pixel, block, units }) {
    const table = element("table"), head = element("tr");
    const side = block.pixels === 64 ? "8 \u00d7 8" : block.pixels + " pixels";
    for (const title of ["", "pixel", "mean of " + side]) head.append(element("th", title));
    table.append(head);
    const add = (name, text) => {
      const line = element("tr");
      line.append(element("td", name));
      for (const reading of [pixel, block])
        line.append(element("td", reading.samples ? text(reading) : "not yet"));
      table.append(line);
    };
    const scaled = (factor) => (reading) =>
      reading.error === undefined ? digits(factor * reading.luminance)
        : withError(factor * reading.luminance, factor * reading.error);
    if (units.cd_per_m2) add("luminance, cd/m\u00b2", scaled(units.cd_per_m2));
    if (units.radiance) add("radiance, W/(m\u00b2 sr)", scaled(units.radiance));
    if (!units.cd_per_m2 && tellsLuminance(units)) add("Y of the pixels", scaled(1));
    ["R", "G", "B"].forEach((name, band) => add(name, (reading) => digits(reading.color[band])));
    add("samples", (reading) => reading.samples.toLocaleString("en"));
    return table;
  }

  notes({ pixel, variance, shares, more, units }) {
    const notes = [];
    if (!variance)
      notes.push("Its error is not known: that takes --aov variance.");
    else if (pixel.samples && pixel.error === undefined)
      notes.push("Its error is not known: of one sample there is none.");
    else
      notes.push("\u00b1 is the standard error, as if samples were independent" +
        (shares ? "; the mean's is at most that, for pixels share samples." : "."));
    if (units.about) notes.push(units.about);
    if (more) notes.push("Results are still being read.");
    return notes.map((text) => element("p", text));
  }
}
