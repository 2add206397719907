// The spectrum of one pixel, where the film has bands: a plot over the picture.
"use strict";

const kPlot = { width: 330, height: 150, left: 52, right: 10, top: 12, bottom: 22 };

function drawing(tag, attributes, text) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

class SpectrumPlot {
  constructor(figure) { this.figure = figure; this.asked = 0; }

  hide() { ++this.asked; this.figure.hidden = true; }

  /// Asks for a pixel of the film and shows it, unless another is asked for in the meantime.
  async show(source, x, y) {
    const asked = ++this.asked, { job, layer } = source;
    const where = new URLSearchParams({ job, layer, x: x - source.x0, y: y - source.y0 });
    const found = await ask("spectrum?" + where).catch((error) => tell(error.message));
    if (!found || asked !== this.asked) return;
    const samples = found.samples + (found.samples === 1 ? " sample" : " samples");
    const caption = element("figcaption", x + ", " + y + ": " + (found.samples ? samples : "not yet"));
    this.figure.replaceChildren(caption, this.plot(found));
    this.figure.hidden = false;
  }

  /// A step for each band, from 0 or the least value to the largest.
  plot({ nm, values }) {
    const { width, height, left, right, top, bottom } = kPlot;
    const image = drawing("svg", { viewBox: "0 0 " + width + " " + height, role: "img" });
    if (!values.length) return image;
    const half = nm.length > 1 ? (nm[1] - nm[0]) / 2 : 5;
    const first = nm[0] - half, last = nm[nm.length - 1] + half;
    const least = Math.min(0, ...values), most = Math.max(0, ...values), range = most - least || 1;
    const u = (at) => left + (at - first) / (last - first) * (width - left - right);
    const v = (at) => height - bottom - (at - least) / range * (height - top - bottom);
    const step = (value, i) => (i ? "L" : "M") + u(nm[i] - half).toFixed(1) + " " + v(value).toFixed(1) +
      "H" + u(nm[i] + half).toFixed(1);
    image.append(drawing("title", {}, "Radiance per nanometre over wavelengths"),
      drawing("path", { class: "axis", d: "M" + left + " " + top + "V" + v(0) + "H" + (width - right) }),
      drawing("path", { class: "curve", d: values.map(step).join("") }));
    for (const [value, at] of [[most, v(most)], [0, v(0)]])
      image.append(drawing("text", { x: left - 4, y: at + 4, class: "end" }, digits(value)));
    const mark = [10, 20, 50, 100, 200].find((size) => (last - first) / size <= 6);
    for (let at = Math.ceil(first / mark) * mark; at <= last; at += mark)
      image.append(drawing("text", { x: u(at), y: height - 6, class: "middle" }, String(at)));
    image.append(drawing("text", { x: width - right, y: 10, class: "end" }, "nm"));
    return image;
  }
}
