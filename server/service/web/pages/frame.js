// The picture of a job: pieces of 256 x 256 pixels at the level of detail that the screen can show, made
// visible by one table lookup a value.
"use strict";

const kSide = 256; // pixels of a piece
const kMostPieces = 400;
const kMostFetches = 6;

/// Pieces of one layer of one job, fetched when they are looked at.
class FrameSource {
  constructor(job, settings, layer, changed) {
    Object.assign(this, { job, layer, changed });
    this.color = settings.layers.find((known) => known.name === layer).color;
    this.hasBands = settings.layers.some(({ name }) => name.startsWith("S0."));
    const [x0, y0, x1, y1] = settings.crop;
    Object.assign(this, { x0, y0, width: x1 - x0, height: y1 - y0 });
    this.top = Math.max(0, Math.ceil(Math.log2(Math.max(this.width, this.height) / kSide)));
    this.pieces = new Map();
    this.fetches = 0;
    this.range = 0;
    this.version = 0; // changes of the coarsest piece
    this.time = 0;
    this.closed = false;
    this.arrived = false; // true once the coordinator has told a piece
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
      piece = {
        key, level, column, row, width, height, data: null, dirty: [0, 0, width, height], busy: false,
        painted: "", canvas: null, failed: -Infinity,
      };
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
        Math.min(piece.width, Math.max(dirty[2], box[2])),
        Math.min(piece.height, Math.max(dirty[3], box[3]))];
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
    const old = [...this.pieces.values()].filter((piece) => !piece.busy);
    old.sort((a, b) => a.used - b.used);
    for (const piece of old.slice(0, this.pieces.size - kMostPieces)) this.pieces.delete(piece.key);
  }

  async fetch(piece) {
    const [x0, y0, x1, y1] = piece.dirty;
    piece.dirty = null;
    piece.busy = true;
    ++this.fetches;
    try {
      const left = piece.column * kSide, top = piece.row * kSide;
      const where = new URLSearchParams({
        job: this.job, layer: this.layer, level: piece.level,
        x0: left + x0, y0: top + y0, x1: left + x1, y1: top + y1,
      });
      if (this.fresh) where.set("fresh", "1");
      const response = await fetch("api/pixels?" + where);
      if (!response.ok) throw new Error(response.status);
      this.more = response.headers.get("X-Tessera-More") === "1";
      const bytes = await response.arrayBuffer();
      if (this.closed) return;
      const values = this.color ? new Uint16Array(bytes) : new Float32Array(bytes);
      this.store(piece, x0, y0, x1 - x0, y1 - y0, values);
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
    this.arrived = true;
    const bands = this.color ? 4 : 1;
    const size = piece.width * piece.height;
    if (!piece.data) piece.data = this.color ? new Uint16Array(4 * size) : new Float32Array(size).fill(NaN);
    for (let row = 0; row < height; ++row) {
      const from = values.subarray(row * width * bands, (row + 1) * width * bands);
      piece.data.set(from, ((y + row) * piece.width + x) * bands);
    }
    piece.painted = "";
    if (piece.level === this.top) ++this.version;
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
    const image = context.createImageData(piece.width, piece.height);
    if (this.color && look.light) this.paintLight(piece.data, look.light, image.data);
    else if (this.color) this.paintColors(piece.data, look, image.data);
    else this.paintNumbers(piece.data, look, image.data);
    context.putImageData(image, 0, 0);
    piece.painted = key;
    return piece.canvas;
  }

  paintColors(data, look, out) {
    const { table, mix } = look.tone, channel = look.channel;
    for (let at = 0; at < data.length; at += 4) {
      if (data[at + 3] === 0) continue;
      if (mix && channel < 0) {
        const codes = mix(data[at], data[at + 1], data[at + 2]);
        for (let band = 0; band < 3; ++band) out[at + band] = 255 * codes[band];
        out[at + 3] = 255;
        continue;
      }
      const r = table[data[at]], g = table[data[at + 1]], b = table[data[at + 2]];
      if (channel < 0) {
        out[at] = r; out[at + 1] = g; out[at + 2] = b;
      } else {
        out[at] = out[at + 1] = out[at + 2] =
          channel < 3 ? table[data[at + channel]] : 0.2126 * r + 0.7152 * g + 0.0722 * b;
      }
      out[at + 3] = 255;
    }
  }

  /// Luminance in the colours of a map.
  paintLight(data, { scale, weights }, out) {
    for (let at = 0; at < data.length; at += 4) {
      if (data[at + 3] === 0) continue;
      const place = scale.place(lightOf(data, at, weights));
      const color = 3 * Math.max(0, Math.min(255, Math.round(255 * place)));
      for (let band = 0; band < 3; ++band) out[at + band] = kCividis[color + band];
      out[at + 3] = 255;
    }
  }

  /// The units of the picture's numbers, once they were asked for and told; null until then.
  light() {
    if (this.units === undefined) {
      this.units = null;
      ask("units?" + new URLSearchParams({ job: this.job })).then((units) => {
        this.units = units;
        this.changed();
      }).catch((error) => tell(error.message));
    }
    return this.units;
  }

  paintNumbers(data, look, out) {
    const scale = 255 * 2 ** look.exposure / (this.range || 1);
    for (let i = 0; i < data.length; ++i) {
      if (Number.isNaN(data[i])) continue;
      const heat = 3 * Math.max(0, Math.min(255, Math.floor(data[i] * scale)));
      for (let band = 0; band < 3; ++band) out[4 * i + band] = kHeat[heat + band];
      out[4 * i + 3] = 255;
    }
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
