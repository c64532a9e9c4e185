"use strict";

// The list of planes with their sizes, and all sizes at a glance above it.

snhc.Planes = class {
  constructor(stream, host, skyline, select) {
    this.stream = stream;
    this.host = host;
    this.skyline = skyline;
    this.select = select;
    this.selected = -1;
    this.largest = stream.planes.reduce((most, part) => Math.max(most, stream.planeBits(part)), 1);
    this.listing = new snhc.Listing(host, { height: 22, row: (index) => this._row(index) });
    this.listing.resize(stream.planes.length);
    host.addEventListener("click", (event) => {
      const row = event.target.closest("[data-index]");
      if (row) this.choose(Number(row.dataset.index));
    });
    host.addEventListener("keydown", (event) => this._key(event));
    skyline.addEventListener("click", (event) => {
      const box = skyline.getBoundingClientRect();
      this.choose(Math.floor(((event.clientX - box.left) / box.width) * stream.planes.length));
    });
    skyline.setAttribute("aria-label", this._words());
    new ResizeObserver(() => this.paint()).observe(skyline);
  }

  _words() {
    const { planes } = this.stream;
    if (!planes.length) return "no planes";
    const sizes = planes.map((part) => this.stream.planeBits(part));
    const total = sizes.reduce((sum, size) => sum + size, 0);
    const intra = planes.filter((part) => this.stream.isIntra(part)).length;
    return `${snhc.count(planes.length, "plane")}, ${intra} intra; ${Math.round(total / planes.length)} bits on average, the largest ${this.largest}`;
  }

  _row(index) {
    const part = this.stream.planes[index];
    const bits = this.stream.planeBits(part);
    const findings = this.stream.findingsOf.get(part) || [];
    const bar = snhc.make("span", { class: "bar" });
    bar.style.setProperty("--size", `${Math.max(1.5, (bits / this.largest) * 100)}%`);
    const words = snhc.planeWords(this.stream, part);
    return snhc.make("div", {
      id: `plane-${index}`, role: "option", "aria-selected": String(index === this.selected), "data-index": index, title: words,
      class: this.stream.isIntra(part) ? "intra" : "", "aria-setsize": this.stream.planes.length, "aria-posinset": index + 1,
      "aria-label": `plane ${this.stream.parts.plane[part]}, ${words}, ${bits} bits${findings.length ? ", " + snhc.count(findings.length, "finding") : ""}`,
    }, snhc.make("span", { class: "number" }, String(this.stream.parts.plane[part])), bar,
      snhc.make("span", { class: "size" }, String(bits)),
      snhc.make("span", { class: findings.some((one) => one.severity === "error") ? "mark" : "mark mild" }, findings.some((one) => one.severity !== "info") ? "▲" : ""));
  }

  show(part) {
    this.selected = this.stream.planes.indexOf(part);
    if (this.selected >= 0) {
      this.listing.scrollTo(this.selected);
      this.host.setAttribute("aria-activedescendant", `plane-${this.selected}`);
    }
    this.listing.refresh();
    this.paint();
  }

  choose(index) {
    if (!this.stream.planes.length) return;
    const part = this.stream.planes[Math.max(0, Math.min(this.stream.planes.length - 1, index))];
    this.select({ part, row: -1, symbol: -1, bits: this.stream.span(part) }, this);
  }

  _key(event) {
    const to = {
      ArrowDown: this.selected + 1, ArrowUp: this.selected - 1, Home: 0, End: this.stream.planes.length - 1,
      PageDown: this.selected + this.listing.page, PageUp: this.selected - this.listing.page,
    }[event.key];
    if (to === undefined) return;
    this.choose(to);
    event.preventDefault();
  }

  paint() {
    const { planes } = this.stream;
    snhc.draw(this.skyline, (context, width, height) => {
      // The largest plane of each column of pixels.
      const columns = Math.min(planes.length, Math.floor(width));
      const step = width / Math.max(1, columns);
      for (let column = 0; column < columns; column++) {
        const first = Math.floor((column / columns) * planes.length);
        const last = Math.max(first + 1, Math.floor(((column + 1) / columns) * planes.length));
        let most = 0;
        let intra = false;
        for (let i = first; i < last; i++) {
          most = Math.max(most, this.stream.planeBits(planes[i]));
          intra = intra || this.stream.isIntra(planes[i]);
        }
        const tall = Math.max(1, (most / this.largest) * (height - 10));
        context.fillStyle = snhc.colour(intra ? "k-head" : "k-data");
        context.globalAlpha = this.selected >= first && this.selected < last ? 1 : 0.55;
        context.fillRect(column * step, height - tall, Math.max(1, step - (step > 3 ? 1 : 0)), tall);
      }
      if (this.selected >= 0) {
        context.globalAlpha = 1;
        context.fillStyle = snhc.colour("accent");
        const x = ((this.selected + 0.5) / planes.length) * width;
        context.beginPath();
        context.moveTo(x - 4, 0);
        context.lineTo(x + 4, 0);
        context.lineTo(x, 6);
        context.fill();
      }
    });
  }
};
