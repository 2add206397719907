// The frames of an animation, as thumbnails beside each other.
"use strict";

const kMostFrames = 500;
const kThumbnail = 64; // pixels, their height
const kAgain = 3000;   // ms between two looks at a frame that is being rendered
const kMoreAfter = 300; // the same, where the coordinator was not done with reading

class Strip {
  /// `jobs`: rows by id. `settingsOf`: of the job that is shown; its animation's frames have the same.
  constructor(place, jobs) {
    Object.assign(this, { place, jobs, cells: new Map(), busy: false, timer: 0, group: "" });
    const tone = new Tone();
    tone.set(0, 0);
    this.look = { tone, channel: -1, key: "thumbnail" };
    this.seen = new IntersectionObserver((entries) => {
      for (const entry of entries) entry.target.cell.visible = entry.isIntersecting;
      this.load();
    }, { root: place, rootMargin: "0px 200px" });
  }

  /// Shows the frames that go with this job, if there are others: those around it.
  show(job, settings) {
    const group = job && settings ? job.group || "" : "";
    const rows = group ? [...this.jobs.values()].filter((row) => row.group === group) : [];
    rows.sort((a, b) => a.frame - b.frame || a.submitted - b.submitted);
    this.place.hidden = rows.length < 2;
    if (group !== this.group || this.place.hidden) this.clear();
    this.group = group;
    if (this.place.hidden) return;
    const at = rows.findIndex((row) => row.id === job.id);
    const first = Math.max(0, Math.min(at - kMostFrames / 2, rows.length - kMostFrames));
    const kept = rows.slice(first, first + kMostFrames), ids = new Set(kept.map((row) => row.id));
    for (const id of [...this.cells.keys()]) if (!ids.has(id)) this.drop(id);
    for (const row of kept) this.draw(row, row.id === job.id, settings);
    const order = kept.map((row) => this.cells.get(row.id).link);
    if (order.some((link, i) => this.place.children[i] !== link)) this.place.replaceChildren(...order);
    this.load();
  }

  clear() {
    for (const id of [...this.cells.keys()]) this.drop(id);
    this.place.replaceChildren();
  }
  drop(id) {
    const cell = this.cells.get(id);
    this.seen.unobserve(cell.link);
    cell.source.close();
    this.cells.delete(id);
  }

  draw(row, current, settings) {
    let cell = this.cells.get(row.id);
    if (!cell) {
      const link = element("a"), canvas = element("canvas"), label = element("span");
      link.href = "#/job/" + row.id;
      link.append(canvas, label);
      const source = new FrameSource(row.id, settings, settings.layers[0].name, () => this.load());
      source.fresh = true;
      canvas.width = Math.max(8, Math.round(kThumbnail * source.width / source.height));
      canvas.height = kThumbnail;
      cell = link.cell = { link, canvas, label, source, visible: false, asked: -1, time: 0 };
      this.cells.set(row.id, cell);
      this.seen.observe(link);
    }
    if (cell.row === row && cell.current === current) return;
    Object.assign(cell, { row, current });
    cell.link.className = "state " + row.state;
    cell.link.title = "frame " + row.frame + ", " + stateOf(row) + ", " + percent(row);
    cell.label.textContent = row.frame;
    current ? cell.link.setAttribute("aria-current", "true") : cell.link.removeAttribute("aria-current");
  }

  /// Fetches what is in sight and has changed, one after the other, and paints what is there.
  load() {
    let least = Infinity;
    for (const cell of this.cells.values()) {
      const piece = cell.source.piece(cell.source.top, 0, 0);
      if (piece.data && !piece.painted) {
        const context = cell.canvas.getContext("2d");
        context.drawImage(cell.source.paint(piece, this.look), 0, 0, cell.canvas.width, cell.canvas.height);
      }
      if (this.busy || !cell.visible || cell.asked === cell.row.done) continue;
      const wait = cell.time + kAgain - performance.now();
      if (wait > 0) { least = Math.min(least, wait); continue; }
      this.busy = true;
      cell.asked = cell.row.done;
      cell.time = performance.now();
      piece.dirty = [0, 0, piece.width, piece.height];
      cell.source.fetch(piece).finally(() => {
        if (cell.source.more) cell.asked = -1, cell.time -= kAgain - kMoreAfter;
        this.busy = false;
        this.load();
      });
    }
    // One timer, however often this is called.
    clearTimeout(this.timer);
    if (least < Infinity) this.timer = setTimeout(() => this.load(), least + 10);
  }
}
