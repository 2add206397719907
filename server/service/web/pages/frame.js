// The picture of a job: pieces of 256 x 256 pixels at the level of detail that the screen can show, made visible by one table lookup a
// value.
"use strict";

const kSide = 256;      // pixels of a piece
const kMostPieces = 400;
const kMostFetches = 6;

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
      if (curve === 1) value = value > 1e4 ? 1 : value * (2.51 * value + 0.03) / (value * (2.43 * value + 0.59) + 0.14);
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
    for (let band = 0; band < 3; ++band) table[3 * i + band] = stops[k][band] + (t - k) * (stops[k + 1][band] - stops[k][band]);
  }
  return table;
})();

/// Pieces of one layer of one job, fetched when they are looked at.
class FrameSource {
  constructor(job, settings, layer, changed) {
    Object.assign(this, { job, layer, changed });
    this.color = settings.layers.find((known) => known.name === layer).color;
    const [x0, y0, x1, y1] = settings.crop;
    Object.assign(this, { x0, y0, width: x1 - x0, height: y1 - y0 });
    this.top = Math.max(0, Math.ceil(Math.log2(Math.max(this.width, this.height) / kSide)));
    this.pieces = new Map();
    this.fetches = 0;
    this.range = 0;
    this.time = 0;
    this.closed = false;
    this.more = false; // the coordinator has not read all results of a fresh picture
    this.fresh = false; // true where no stream of events keeps the coordinator's picture up to date
  }

  levelSize(level) { return [Math.ceil(this.width / 2 ** level), Math.ceil(this.height / 2 ** level)]; }

  piece(level, column, row) {
    const key = level + "/" + column + "/" + row;
    let piece = this.pieces.get(key);
    if (!piece) {
      const [w, h] = this.levelSize(level);
      const width = Math.min(kSide, w - column * kSide), height = Math.min(kSide, h - row * kSide);
      piece = { key, level, column, row, width, height, data: null, dirty: [0, 0, width, height], busy: false, painted: "", canvas: null, failed: 0 };
      this.pieces.set(key, piece);
    }
    piece.used = ++this.time;
    return piece;
  }

  /// Pixels of the film changed.
  invalidate(x0, y0, x1, y1) {
    for (const piece of this.pieces.values()) {
      const scale = 2 ** piece.level, left = piece.column * kSide, top = piece.row * kSide;
      const box = [Math.floor((x0 - this.x0) / scale) - left, Math.floor((y0 - this.y0) / scale) - top,
        Math.ceil((x1 - this.x0) / scale) - left, Math.ceil((y1 - this.y0) / scale) - top];
      if (box[2] <= 0 || box[3] <= 0 || box[0] >= piece.width || box[1] >= piece.height) continue;
      const dirty = piece.dirty || box;
      piece.dirty = [Math.max(0, Math.min(dirty[0], box[0])), Math.max(0, Math.min(dirty[1], box[1])),
        Math.min(piece.width, Math.max(dirty[2], box[2])), Math.min(piece.height, Math.max(dirty[3], box[3]))];
    }
    this.changed();
  }
  invalidateAll() { this.invalidate(this.x0, this.y0, this.x0 + this.width, this.y0 + this.height); }

  /// Asks for what is missing of these pieces, the first first.
  want(pieces) {
    for (const piece of pieces) {
      if (this.fetches >= kMostFetches) return;
      if (piece.dirty && !piece.busy && performance.now() > piece.failed + 2000) this.fetch(piece);
    }
    if (this.pieces.size <= kMostPieces) return;
    const old = [...this.pieces.values()].filter((piece) => !piece.busy).sort((a, b) => a.used - b.used);
    for (const piece of old.slice(0, this.pieces.size - kMostPieces)) this.pieces.delete(piece.key);
  }

  async fetch(piece) {
    const [x0, y0, x1, y1] = piece.dirty;
    piece.dirty = null;
    piece.busy = true;
    ++this.fetches;
    try {
      const left = piece.column * kSide, top = piece.row * kSide;
      const where = new URLSearchParams({ job: this.job, layer: this.layer, level: piece.level, x0: left + x0, y0: top + y0, x1: left + x1, y1: top + y1 });
      if (this.fresh) where.set("fresh", "1");
      const response = await fetch("api/pixels?" + where);
      if (!response.ok) throw new Error(response.status);
      this.more = response.headers.get("X-Tessera-More") === "1";
      const bytes = await response.arrayBuffer();
      if (this.closed) return;
      this.store(piece, x0, y0, x1 - x0, y1 - y0, this.color ? new Uint16Array(bytes) : new Float32Array(bytes));
    } catch (error) {
      piece.failed = performance.now();
      piece.dirty = [0, 0, piece.width, piece.height];
      setTimeout(() => this.changed(), 2100);
    } finally {
      piece.busy = false;
      --this.fetches;
      if (!this.closed) this.changed();
    }
  }

  store(piece, x, y, width, height, values) {
    const bands = this.color ? 4 : 1;
    if (!piece.data) piece.data = this.color ? new Uint16Array(piece.width * piece.height * 4) : new Float32Array(piece.width * piece.height).fill(NaN);
    for (let row = 0; row < height; ++row)
      piece.data.set(values.subarray(row * width * bands, (row + 1) * width * bands), ((y + row) * piece.width + x) * bands);
    piece.painted = "";
    if (!this.color && piece.level === this.top) this.measure(piece.data);
  }

  /// The scale of maps: what all but the largest two in a hundred values are below.
  measure(values) {
    const known = values.filter((value) => Number.isFinite(value)).sort();
    const range = known.length ? known[Math.floor(0.98 * (known.length - 1))] : 0;
    if (range > 0 && Math.abs(range - this.range) > 0.05 * this.range) {
      this.range = range;
      for (const piece of this.pieces.values()) piece.painted = "";
    }
  }

  /// The piece as it is shown, painted anew where it has to be.
  paint(piece, look) {
    const key = look.key + " " + this.range;
    if (piece.painted === key) return piece.canvas;
    if (!piece.canvas) {
      piece.canvas = document.createElement("canvas");
      piece.canvas.width = piece.width;
      piece.canvas.height = piece.height;
    }
    const context = piece.canvas.getContext("2d");
    const image = context.createImageData(piece.width, piece.height), out = image.data, data = piece.data;
    const count = piece.width * piece.height;
    if (this.color) {
      const table = look.tone.table, channel = look.channel;
      for (let i = 0; i < count; ++i) {
        const at = 4 * i;
        if (data[at + 3] === 0) continue;
        if (channel < 0) {
          out[at] = table[data[at]]; out[at + 1] = table[data[at + 1]]; out[at + 2] = table[data[at + 2]];
        } else {
          const value = channel < 3 ? table[data[at + channel]]
            : 0.2126 * table[data[at]] + 0.7152 * table[data[at + 1]] + 0.0722 * table[data[at + 2]];
          out[at] = out[at + 1] = out[at + 2] = value;
        }
        out[at + 3] = 255;
      }
    } else {
      const scale = 255 * 2 ** look.exposure / (this.range || 1);
      for (let i = 0; i < count; ++i) {
        if (Number.isNaN(data[i])) continue;
        const heat = 3 * Math.max(0, Math.min(255, Math.floor(data[i] * scale)));
        out[4 * i] = kHeat[heat]; out[4 * i + 1] = kHeat[heat + 1]; out[4 * i + 2] = kHeat[heat + 2]; out[4 * i + 3] = 255;
      }
    }
    context.putImageData(image, 0, 0);
    piece.painted = key;
    return piece.canvas;
  }

  /// The values of a pixel of the film, from the finest piece that is here.
  valueAt(x, y) {
    for (let level = 0; level <= this.top; ++level) {
      const u = Math.floor((x - this.x0) / 2 ** level), v = Math.floor((y - this.y0) / 2 ** level);
      const piece = this.pieces.get(level + "/" + Math.floor(u / kSide) + "/" + Math.floor(v / kSide));
      if (!piece || !piece.data) continue;
      const at = v % kSide * piece.width + u % kSide;
      if (!this.color) return { level, values: [piece.data[at]] };
      const values = [0, 1, 2].map((band) => fromHalf(piece.data[4 * at + band]));
      return piece.data[4 * at + 3] ? { level, values } : null;
    }
    return null;
  }

  close() { this.closed = true; this.pieces.clear(); }
}

/// The canvas: where one looks, and what lies over it.
class Viewer {
  constructor(stage) {
    this.stage = stage;
    this.canvas = stage.querySelector("#canvas");
    this.over = stage.querySelector("#over");
    this.wipe = stage.querySelector("#wipe");
    this.pixel = stage.querySelector("#pixel");
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
    const same = before && source && before.width === source.width && before.height === source.height && before.job === source.job;
    Object.assign(this, { source, other });
    this.wipe.hidden = !other;
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
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); this.pointers.set(event.pointerId, event); });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      this.tell(event.offsetX, event.offsetY);
      const before = this.pointers.get(event.pointerId);
      if (!before) return;
      const others = [...this.pointers.values()].filter((pointer) => pointer.pointerId !== event.pointerId);
      if (others.length === 1) {
        const far = (a, b) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1;
        this.zoomTo(this.view.scale * far(event, others[0]) / far(before, others[0]), event.offsetX, event.offsetY);
      } else {
        this.pan(event.clientX - before.clientX, event.clientY - before.clientY);
      }
      this.pointers.set(event.pointerId, event);
    });
    canvas.addEventListener("pointerleave", () => { this.pixel.textContent = ""; });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] }[event.key];
      if (step) this.pan(...step);
      else if (event.key === "+" || event.key === "=") this.zoomTo(this.view.scale * 2);
      else if (event.key === "-") this.zoomTo(this.view.scale / 2);
      else if (event.key === "0") this.fit();
      else if (event.key === "1") this.zoomTo(1);
      else return;
      event.preventDefault();
    });
    this.wipe.addEventListener("pointerdown", (event) => this.wipe.setPointerCapture(event.pointerId));
    this.wipe.addEventListener("pointermove", (event) => {
      if (!this.wipe.hasPointerCapture(event.pointerId)) return;
      const box = this.stage.getBoundingClientRect();
      this.split = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      this.changed();
    });
  }

  tell(px, py) {
    if (!this.source) return;
    const x = Math.floor(this.view.x + px / this.view.scale) + this.source.x0, y = Math.floor(this.view.y + py / this.view.scale) + this.source.y0;
    const inside = x >= this.source.x0 && y >= this.source.y0 && x < this.source.x0 + this.source.width && y < this.source.y0 + this.source.height;
    if (!inside) { this.pixel.textContent = ""; return; }
    const of = (source) => {
      const found = source.valueAt(x, y);
      return found ? found.values.map(digits).join("  ") + (found.level ? "  (mean of " + 2 ** found.level + " x " + 2 ** found.level + ")" : "") : "not yet";
    };
    const right = this.other && px > this.split * this.stage.clientWidth;
    const tile = this.work.find((area) => x >= area[0] && y >= area[1] && x < area[2] && y < area[3]);
    this.pixel.textContent = x + ", " + y + "   " + of(right ? this.other : this.source) + (tile ? "   " + workerName(tile[4]) : "");
  }

  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  draw() {
    const { clientWidth: w, clientHeight: h } = this.stage, dpr = devicePixelRatio || 1;
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
    const look = { key: this.tone.key + " " + this.look.channel, tone: this.tone, channel: this.look.channel, exposure: this.look.exposure };
    context.setTransform(dpr, 0, 0, dpr, 0, 0);
    this.drawSource(context, this.source, look, 0, this.other ? this.split * w : w, dpr);
    if (this.other) this.drawSource(context, this.other, look, this.split * w, w, dpr);
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
          context.drawImage(source.paint(piece, look), (column * kSide * size - x) * scale, (row * kSide * size - y) * scale,
            piece.width * size * scale, piece.height * size * scale);
        }
      }
    }
    context.restore();
    // From the middle of the screen outwards.
    const far = (piece) => Math.hypot((piece.column + 0.5) * kSide * 2 ** piece.level - (x + w / scale / 2), (piece.row + 0.5) * kSide * 2 ** piece.level - (y + h / scale / 2));
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
      const left = (x0 - this.source.x0 - x) * scale, top = (y0 - this.source.y0 - y) * scale, width = (x1 - x0) * scale, height = (y1 - y0) * scale;
      if (left > w || top > h || left + width < 0 || top + height < 0) continue;
      context.strokeStyle = "hsl(" + hueOf(worker) + " 85% 62%)";
      context.strokeRect(left + 1, top + 1, Math.max(1, width - 2), Math.max(1, height - 2));
    }
  }
}
