"use strict";

// The bytes, and the bits of the selected ones. A click in a byte hits the bit below it.

const PER_LINE = 8;
const STRIP_BYTES = 4;

snhc.HexView = class {
  constructor(stream, host, strip, place, select) {
    this.stream = stream;
    this.host = host;
    this.strip = strip;
    this.place = place;
    this.select = select;
    this.bit = -1;
    this.bits = null;
    this.lines = Math.ceil(stream.bytes.length / PER_LINE);
    host.setAttribute("aria-rowcount", this.lines);
    host.setAttribute("aria-colcount", PER_LINE);
    this.listing = new snhc.Listing(host, { height: 21, row: (index) => this._row(index) });
    this.listing.resize(this.lines);
    host.addEventListener("click", (event) => this._click(event));
    host.addEventListener("keydown", (event) => this._key(event));
    strip.addEventListener("click", (event) => {
      const button = event.target.closest("[data-bit]");
      if (button) this.choose(Number(button.dataset.bit));
    });
  }

  kindAt(bit) {
    const gap = this.stream.data.unclaimed;
    if (gap && bit >= gap[0]) return "gap";
    const row = this.stream.rowAt(bit);
    return row < 0 ? "gap" : this.stream.kindOfRow(row);
  }

  _row(index) {
    const stream = this.stream;
    const cells = [];
    let text = "";
    const first = index * PER_LINE;
    for (let i = first; i < Math.min(first + PER_LINE, stream.bytes.length); i++) {
      const value = stream.bytes[i];
      const bit = stream.firstBit + i * 8;
      const cell = snhc.make("span", {
        role: "gridcell", "aria-colindex": i - first + 1, "data-byte": i, class: `byte k-${this.kindAt(bit)}${i - first === PER_LINE / 2 ? " half" : ""}`,
        "aria-selected": this.bits ? String(this.bits[0] < bit + 8 && this.bits[1] > bit) : null,
        id: `byte-${i}`,
      }, value.toString(16).padStart(2, "0"));
      if (this.bits) this._shade(cell, bit);
      cells.push(cell);
      text += value >= 32 && value < 127 ? String.fromCharCode(value) : "·";
    }
    const offset = (this.stream.data.firstByte + first).toString(16).padStart(6, "0");
    return snhc.make("div", { role: "row", "aria-rowindex": index + 1 },
      snhc.make("span", { class: "offset", role: "rowheader" }, offset), ...cells,
      snhc.make("span", { class: "text", "aria-hidden": "true" }, text));
  }

  // The part of a byte that is selected, to the bit.
  _shade(cell, bit) {
    const from = Math.max(0, this.bits[0] - bit);
    const to = Math.min(8, this.bits[1] - bit);
    if (from >= to) return;
    cell.style.background = `linear-gradient(90deg, transparent ${from * 12.5}%, var(--select) ${from * 12.5}% ${to * 12.5}%, transparent ${to * 12.5}%)`;
    if (this.bit >= bit && this.bit < bit + 8) cell.style.boxShadow = "inset 0 -2px var(--accent)";
  }

  show(bits, bit = bits ? bits[0] : -1, scroll = true) {
    this.bits = bits;
    this.bit = bit;
    if (bit >= 0 && scroll) this.listing.scrollTo((bit - this.stream.firstBit) >> 3 >= 0 ? Math.floor((bit - this.stream.firstBit) / 8 / PER_LINE) : 0);
    this.listing.refresh();
    this._strip();
    if (bit >= 0) this.host.setAttribute("aria-activedescendant", `byte-${Math.floor((bit - this.stream.firstBit) / 8)}`);
  }

  _strip() {
    const stream = this.stream;
    if (this.bit < stream.firstBit || this.bit >= stream.endBit) {
      this.strip.replaceChildren();
      this.place.textContent = "";
      return;
    }
    const byte = Math.floor((this.bit - stream.firstBit) / 8);
    const begin = Math.max(0, Math.min(byte - 1, stream.bytes.length - STRIP_BYTES));
    const octets = [];
    for (let i = begin; i < Math.min(begin + STRIP_BYTES, stream.bytes.length); i++) {
      const buttons = [];
      for (let k = 0; k < 8; k++) {
        const bit = stream.firstBit + i * 8 + k;
        const row = stream.rowAt(bit);
        const inside = this.bits && bit >= this.bits[0] && bit < this.bits[1];
        buttons.push(snhc.make("button", {
          type: "button", "data-bit": bit, class: `k-${this.kindAt(bit)}${inside ? " in" : ""}`, "aria-pressed": String(bit === this.bit),
          "aria-label": `bit ${bit} is ${stream.bit(bit)}, ${row < 0 ? "unclaimed" : stream.element(row).name}`, title: `bit ${bit}: ${row < 0 ? "unclaimed" : stream.element(row).name}`,
          tabindex: bit === this.bit ? 0 : -1,
        }, String(stream.bit(bit))));
      }
      octets.push(snhc.make("span", { class: "octet" }, ...buttons));
    }
    const focused = this.strip.contains(document.activeElement);
    this.strip.replaceChildren(...octets);
    if (focused) this.strip.querySelector('[aria-pressed="true"]').focus();
    const at = Math.floor(this.bit / 8);
    this.place.textContent = `bit ${this.bit.toLocaleString("en")} · byte 0x${at.toString(16).padStart(6, "0")}, bit ${this.bit % 8}` +
      (this.bits ? ` · selected [${this.bits[0]}, ${this.bits[1]})` : "");
  }

  choose(bit) {
    if (bit < this.stream.firstBit || bit >= this.stream.endBit) return;
    const row = this.stream.rowAt(bit);
    const segment = row >= 0 ? this.stream.segmentOf(row) : -1;
    const symbol = segment >= 0 ? this.stream.symbolAt(segment, bit) : -1;
    this.select({ part: row >= 0 ? this.stream.partOfRow(row) : -1, row, symbol, bit }, this);
  }

  _click(event) {
    const cell = event.target.closest("[data-byte]");
    if (!cell) return;
    const box = cell.getBoundingClientRect();
    const within = Math.max(0, Math.min(7, Math.floor(((event.clientX - box.left) / box.width) * 8)));
    this.choose(this.stream.firstBit + Number(cell.dataset.byte) * 8 + within);
  }

  _key(event) {
    const line = PER_LINE * 8;
    const now = this.bit < 0 ? this.stream.firstBit : this.bit;
    const to = {
      ArrowRight: now + (event.shiftKey ? 8 : 1), ArrowLeft: now - (event.shiftKey ? 8 : 1), ArrowDown: now + line, ArrowUp: now - line,
      PageDown: now + line * this.listing.page, PageUp: now - line * this.listing.page, Home: this.stream.firstBit, End: this.stream.endBit - 1,
    }[event.key];
    if (to === undefined) return;
    this.choose(Math.max(this.stream.firstBit, Math.min(this.stream.endBit - 1, to)));
    event.preventDefault();
  }
};
