// A table of any number of rows, of which those in sight exist.
"use strict";

class Table {
  /// `columns`: {title, width, cell(row) -> text or node, value(row) -> what sorts, num, wide}.
  /// `open(row)` is called for a row that is clicked or entered.
  constructor(place, columns, { open, sort = 0, down = false, height = 34, empty = "" } = {}) {
    Object.assign(this, { place, columns, open, height, sort, down, empty });
    this.rows = new Map();
    this.order = [];
    this.filter = "";
    this.at = null;
    this.shown = new Map();
    const narrow = matchMedia("(max-width: 760px)");
    narrow.addEventListener("change", () => this.layOut(narrow.matches));
    this.head = document.createElement("div");
    this.head.className = "head";
    this.body = document.createElement("div");
    place.append(this.head, this.body);
    place.tabIndex = 0;
    place.addEventListener("scroll", () => this.draw());
    new ResizeObserver(() => this.draw()).observe(place);
    this.layOut(narrow.matches);
  }

  layOut(narrow) {
    const columns = this.columns.filter((column) => !narrow || !column.wide);
    this.visible = columns;
    this.place.style.setProperty("--columns", columns.map((column) => column.width).join(" "));
    this.head.replaceChildren(...columns.map((column) => {
      const title = document.createElement("span");
      title.textContent = column.title;
      if (column.num) title.className = "num";
      if (column.value) {
        title.style.cursor = "pointer";
        title.addEventListener("click", () => {
          const index = this.columns.indexOf(column);
          this.down = this.sort === index ? !this.down : Boolean(column.num);
          this.sort = index;
          this.changed();
        });
      }
      return title;
    }));
    this.shown.forEach((shown) => shown.node.remove());
    this.shown.clear();
    this.changed();
  }

  set(row) { this.rows.set(row.id, row); this.changed(); }
  remove(id) { this.rows.delete(id); this.changed(); }
  clear() { this.rows.clear(); this.changed(); }
  find(text) { this.filter = text.trim().toLowerCase(); this.changed(); }

  /// Sorts and draws, once for all changes until the next frame.
  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.arrange();
      this.draw();
    });
  }

  arrange() {
    const column = this.columns[this.sort], sign = this.down ? -1 : 1;
    let rows = [...this.rows.values()];
    if (this.filter) rows = rows.filter((row) => this.textOf(row).includes(this.filter));
    if (column && column.value) {
      const values = new Map(rows.map((row) => [row, column.value(row)]));
      rows.sort((a, b) => {
        const x = values.get(a), y = values.get(b);
        return x < y ? -sign : x > y ? sign : 0;
      });
    }
    this.order = rows;
    this.body.style.height = rows.length * this.height + "px";
    this.body.style.position = "relative";
  }

  textOf(row) { return (row.text === undefined ? JSON.stringify(row) : row.text).toLowerCase(); }

  draw() {
    const top = this.place.scrollTop, first = Math.max(0, Math.floor(top / this.height) - 4);
    const last = Math.min(this.order.length, Math.ceil((top + this.place.clientHeight) / this.height) + 4);
    const keep = new Set();
    for (let i = first; i < last; ++i) {
      const row = this.order[i];
      keep.add(row.id);
      let shown = this.shown.get(row.id);
      if (!shown) {
        shown = { node: document.createElement("div"), row: null };
        shown.node.addEventListener("click", () => {
          this.at = row.id;
          this.draw();
          if (this.open) this.open(this.rows.get(row.id));
        });
        this.shown.set(row.id, shown);
        this.body.append(shown.node);
      }
      shown.node.style.top = i * this.height + "px";
      shown.node.className = "row" + (this.open ? " link" : "") + (row.id === this.at ? " at" : "");
      if (shown.row === row) continue;
      shown.row = row;
      shown.node.replaceChildren(...this.visible.map((column) => {
        const content = column.cell(row);
        const cell = document.createElement("span");
        if (column.num) cell.className = "num";
        if (content instanceof Node) cell.append(content);
        else { cell.textContent = content; cell.title = content; }
        return cell;
      }));
    }
    for (const [id, shown] of this.shown) {
      if (keep.has(id)) continue;
      shown.node.remove();
      this.shown.delete(id);
    }
    if (!this.note) {
      this.note = document.createElement("div");
      this.note.className = "empty";
      this.place.append(this.note);
    }
    this.note.hidden = this.order.length > 0;
    this.note.textContent = this.rows.size > 0 ? "Nothing matches." : this.empty;
  }

  key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[event.key];
    const index = this.order.findIndex((row) => row.id === this.at);
    if (step) {
      event.preventDefault();
      const next = Math.min(this.order.length - 1, Math.max(0, index + step));
      if (next < 0) return;
      this.at = this.order[next].id;
      const y = next * this.height, head = this.head.offsetHeight;
      if (y < this.place.scrollTop) this.place.scrollTop = y;
      if (y + this.height + head > this.place.scrollTop + this.place.clientHeight)
        this.place.scrollTop = y + this.height + head - this.place.clientHeight;
      this.draw();
    } else if (event.key === "Enter" && index >= 0 && this.open) {
      this.open(this.order[index]);
    }
  }
}
