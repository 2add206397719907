// The stage: a job's picture, moved and zoomed, perhaps another beside it, and outlines of tiles in work.
"use strict";

const kFalseColors = 5; // in the list of looks, luminance as colours; the one after it is logarithmic
const kSteps = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] }; // pixels

/// The canvas: where one looks, and what lies over it.
class Viewer {
  constructor(stage) {
    this.stage = stage;
    this.canvas = stage.querySelector("#canvas");
    this.over = stage.querySelector("#over");
    this.wipe = stage.querySelector("#wipe");
    this.pixel = stage.querySelector("#pixel");
    this.spectrum = new SpectrumPlot(stage.querySelector("#spectrum"));
    this.meter = new MeterPanel(stage.querySelector("#meter"));
    this.legend = new Legend(stage.querySelector("#legend"));
    this.tone = new Tone();
    this.look = { exposure: 0, curve: 0, channel: -1 };
    this.outlines = true;
    this.work = [];
    this.source = this.other = null;
    this.split = 0.5;
    this.view = { x: 0, y: 0, scale: 1 };
    this.fitted = true;
    this.pointers = new Map();
    new ResizeObserver(() => { if (this.fitted) this.fit(); this.changed(); }).observe(stage);
    this.listen();
  }

  show(source, other) {
    const before = this.source;
    if (before && before !== source) before.close();
    if (this.other && this.other !== other) this.other.close();
    const same = before && source && before.job === source.job && before.width === source.width &&
      before.height === source.height;
    Object.assign(this, { source, other });
    this.wipe.hidden = !other;
    if (!same) this.hideProbes();
    if (!same) this.fit();
    this.changed();
  }

  setLook(look) { Object.assign(this.look, look); this.changed(); }
  setWork(work) { this.work = work; this.changed(); }

  fit() {
    if (!this.source) return;
    const { clientWidth: w, clientHeight: h } = this.stage;
    const scale = Math.min(w / this.source.width, h / this.source.height) || 1;
    this.view = { scale, x: (this.source.width - w / scale) / 2, y: (this.source.height - h / scale) / 2 };
    this.fitted = true;
    this.changed();
  }
  zoomTo(scale, px = this.stage.clientWidth / 2, py = this.stage.clientHeight / 2) {
    scale = Math.min(64, Math.max(1 / 256, scale));
    const x = this.view.x + px / this.view.scale, y = this.view.y + py / this.view.scale;
    this.view = { scale, x: x - px / scale, y: y - py / scale };
    this.fitted = false;
    this.changed();
  }
  pan(dx, dy) {
    this.view.x -= dx / this.view.scale;
    this.view.y -= dy / this.view.scale;
    this.fitted = false;
    this.changed();
  }

  listen() {
    const canvas = this.canvas;
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoomTo(this.view.scale * 2 ** (-event.deltaY / 240), event.offsetX, event.offsetY);
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, event);
      this.pressed = this.pointers.size === 1 ? event : null;
    });
    canvas.addEventListener("pointerup", (event) => {
      const from = this.pressed;
      this.pressed = null;
      if (from && Math.hypot(event.clientX - from.clientX, event.clientY - from.clientY) < 4)
        this.probe(event.offsetX, event.offsetY);
    });
    for (const name of ["pointerup", "pointercancel"])
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    canvas.addEventListener("pointerleave", () => { this.pixel.textContent = ""; });
    this.listenToWipe();
  }

  key(event) {
    const step = kSteps[event.key];
    if (step) this.pan(...step);
    else if (event.key === "+" || event.key === "=") this.zoomTo(this.view.scale * 2);
    else if (event.key === "-") this.zoomTo(this.view.scale / 2);
    else if (event.key === "0") this.fit();
    else if (event.key === "1") this.zoomTo(1);
    else return;
    event.preventDefault();
  }

  listenToWipe() {
    this.wipe.addEventListener("pointerdown", (event) => this.wipe.setPointerCapture(event.pointerId));
    this.wipe.addEventListener("pointermove", (event) => {
      if (!this.wipe.hasPointerCapture(event.pointerId)) return;
      const box = this.stage.getBoundingClientRect();
      this.split = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      this.changed();
    });
  }

  /// One pointer moves the picture, two zoom it.
  moved(event) {
    this.tell(event.offsetX, event.offsetY);
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const others = [...this.pointers.values()].filter((pointer) => pointer.pointerId !== event.pointerId);
    if (others.length === 1) {
      const far = (a, b) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1;
      const times = far(event, others[0]) / far(before, others[0]);
      this.zoomTo(this.view.scale * times, event.offsetX, event.offsetY);
    } else {
      this.pan(event.clientX - before.clientX, event.clientY - before.clientY);
    }
    this.pointers.set(event.pointerId, event);
  }

  /// The pixel of the film at this place of the stage, and whose it is; null beside the picture.
  pixelAt(px, py) {
    if (!this.source) return null;
    const { x0, y0, width, height } = this.source;
    const x = Math.floor(this.view.x + px / this.view.scale) + x0;
    const y = Math.floor(this.view.y + py / this.view.scale) + y0;
    if (!(x >= x0 && y >= y0 && x < x0 + width && y < y0 + height)) return null;
    const right = this.other && px > this.split * this.stage.clientWidth;
    return { x, y, source: right ? this.other : this.source };
  }

  /// Shows the light of the pixel, and its spectrum where the film has bands; beside the picture takes them
  /// away.
  probe(px, py) {
    const at = this.pixelAt(px, py);
    if (at) this.meter.show(at.source, at.x, at.y);
    else this.meter.hide();
    if (at && at.source.hasBands) this.spectrum.show(at.source, at.x, at.y);
    else this.spectrum.hide();
  }
  hideProbes() {
    this.meter.hide();
    this.spectrum.hide();
  }

  /// A scale over the whole first picture, with which its colours are shown as luminances; null where that is
  /// not asked for, or not known yet.
  lightScale() {
    const { curve, exposure } = this.look, source = this.source;
    if (curve < kFalseColors || !source.color) return null;
    const units = source.light(), whole = source.pieces.get(source.top + "/0/0");
    if (!units || !whole || !whole.data) return null;
    const key = [source.job, source.layer, source.version, curve, exposure].join();
    if (this.scaled && this.scaled.key === key) return this.scaled.scale;
    const scale = lightScale(whole.data, weightsOf(units), units.cd_per_m2 || 1, curve > kFalseColors, exposure);
    this.scaled = { key, scale };
    return scale;
  }

  /// The look of a picture on that scale; that of the other one has its own units.
  lightLook(look, scale, source) {
    const units = scale && source.color ? source.light() : null;
    if (!units) return look;
    const factor = (units.cd_per_m2 || 1) / (this.source.light().cd_per_m2 || 1);
    const weights = weightsOf(units).map((weight) => weight * factor);
    return { ...look, key: "light " + scale.key + " " + weights, light: { scale, weights } };
  }

  /// Tells the values of the pixel at this place of the stage, and who works on it.
  tell(px, py) {
    const at = this.pixelAt(px, py);
    this.pixel.textContent = "";
    if (!at) return;
    const { x, y } = at;
    const found = at.source.valueAt(x, y), texts = [x + ", " + y];
    texts.push(found ? found.values.map(digits).join("  ") : "not yet");
    if (found && found.level) texts.push("(mean of " + 2 ** found.level + " x " + 2 ** found.level + ")");
    const tile = this.work.find((area) => x >= area[0] && y >= area[1] && x < area[2] && y < area[3]);
    if (tile) texts.push(workerName(tile[4]));
    this.pixel.textContent = texts.join("   ");
  }

  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  draw() {
    const { clientWidth: w, clientHeight: h } = this.stage, dpr = devicePixelRatio || 1;
    this.stage.classList.toggle("loading", Boolean(this.source) && !this.source.arrived);
    if (!w || !h || !this.source) return;
    for (const canvas of [this.canvas, this.over]) {
      if (canvas.width !== Math.round(w * dpr) || canvas.height !== Math.round(h * dpr)) {
        canvas.width = Math.round(w * dpr);
        canvas.height = Math.round(h * dpr);
      }
    }
    const context = this.canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.tone.set(this.look.exposure, this.look.curve);
    const { channel, exposure } = this.look, scale = this.lightScale();
    const look = { key: this.tone.key + " " + channel, tone: this.tone, channel, exposure };
    scale ? this.legend.show(scale, this.source.light()) : this.legend.hide();
    context.setTransform(dpr, 0, 0, dpr, 0, 0);
    const first = this.lightLook(look, scale, this.source);
    this.drawSource(context, this.source, first, 0, this.other ? this.split * w : w, dpr);
    if (this.other)
      this.drawSource(context, this.other, this.lightLook(look, scale, this.other), this.split * w, w, dpr);
    this.wipe.style.left = this.split * w + "px";
    this.drawOver(w, h, dpr);
  }

  drawSource(context, source, look, left, right, dpr) {
    const { x, y, scale } = this.view, h = this.stage.clientHeight, w = this.stage.clientWidth;
    context.save();
    context.beginPath();
    context.rect(left, 0, right - left, h);
    context.clip();
    const level = Math.min(source.top, Math.max(0, Math.floor(Math.log2(1 / (scale * dpr)) + 1e-6)));
    const wanted = [];
    // The coarsest level first: it is there soon, and stands in for what is not.
    for (const at of level === source.top ? [level] : [source.top, level]) {
      const [width, height] = source.levelSize(at), size = 2 ** at;
      const first = (from) => Math.max(0, Math.floor(from / size / kSide));
      const last = (to, all) => Math.min(Math.ceil(all / kSide), Math.ceil(to / size / kSide));
      for (let row = first(y); row < last(y + h / scale, height); ++row) {
        for (let column = first(x + left / scale); column < last(x + right / scale, width); ++column) {
          const piece = source.piece(at, column, row);
          wanted.push(piece);
          if (!piece.data) continue;
          context.imageSmoothingEnabled = scale * size * dpr < 1;
          context.drawImage(source.paint(piece, look), (column * kSide * size - x) * scale,
            (row * kSide * size - y) * scale, piece.width * size * scale, piece.height * size * scale);
        }
      }
    }
    context.restore();
    // From the middle of the screen outwards.
    const middle = (index, level) => (index + 0.5) * kSide * 2 ** level;
    const far = (piece) => Math.hypot(middle(piece.column, piece.level) - (x + w / scale / 2),
      middle(piece.row, piece.level) - (y + h / scale / 2));
    wanted.sort((a, b) => (b.level - a.level) || far(a) - far(b));
    source.want(wanted);
  }

  drawOver(w, h, dpr) {
    const context = this.over.getContext("2d");
    context.setTransform(dpr, 0, 0, dpr, 0, 0);
    context.clearRect(0, 0, w, h);
    if (!this.outlines) return;
    context.lineWidth = 1.5;
    const { x, y, scale } = this.view;
    for (const [x0, y0, x1, y1, worker] of this.work) {
      const left = (x0 - this.source.x0 - x) * scale, top = (y0 - this.source.y0 - y) * scale;
      const width = (x1 - x0) * scale, height = (y1 - y0) * scale;
      if (left > w || top > h || left + width < 0 || top + height < 0) continue;
      context.strokeStyle = "hsl(" + hueOf(worker) + " 85% 62%)";
      context.strokeRect(left + 1, top + 1, Math.max(1, width - 2), Math.max(1, height - 2));
    }
  }
}
