"use strict";

// Search over all elements: words that a name, rule or path holds, `=value`, or `[bit` to go to a bit.

snhc.Search = class {
  constructor(stream, input, status, tree, select) {
    this.stream = stream;
    this.input = input;
    this.status = status;
    this.tree = tree;
    this.select = select;
    this.hits = [];
    this.at = -1;
    input.addEventListener("input", () => this._find());
    input.form.addEventListener("submit", (event) => event.preventDefault());
    input.addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.step(event.shiftKey ? -1 : 1);
      else if (event.key === "Escape") {
        input.value = "";
        this._find();
        this.tree.host.focus();
      } else return;
      event.preventDefault();
    });
  }

  _find() {
    const { stream } = this;
    const text = this.input.value.trim().toLowerCase();
    this.hits = [];
    this.at = -1;
    const words = text.split(/\s+/).filter(Boolean);
    const bit = /^\[?(\d+)[,)\]]*$/.exec(text);
    if (text.startsWith("[") && bit) {
      this.status.textContent = "Enter: go to the bit";
      this.tree.found = new Set();
      return;
    }
    if (words.length) {
      // Asked once for every element and path, not for every row.
      const value = words.filter((word) => /^=-?\d+$/.test(word)).map((word) => Number(word.slice(1)));
      const rest = words.filter((word) => !/^=-?\d+$/.test(word));
      const ofElement = stream.elements.map((element) => `${element.name} ${element.rule}`.toLowerCase());
      const ofPath = stream.data.paths.map((path) => path.toLowerCase());
      const fits = rest.map((word) => ({ word, element: ofElement.map((one) => one.includes(word)), path: ofPath.map((one) => one.includes(word)) }));
      const plane = rest.map((word) => /^plane\[(\d+)\]$/.exec(word)).map((match) => (match ? Number(match[1]) : null));
      for (let part = 0; part < stream.partCount; part++) {
        for (let row = stream.parts.row[part]; row < stream.partEnd(part); row++) {
          const element = stream.rows.element[row];
          const path = stream.rows.path[row];
          if (value.every((one) => one === stream.rows.value[row]) &&
            fits.every((fit, i) => fit.element[element] || fit.path[path] || (plane[i] !== null && plane[i] === stream.parts.plane[part]))) this.hits.push(row);
        }
      }
    }
    this.tree.found = new Set(this.hits);
    this.tree.listing.refresh();
    this.status.textContent = words.length ? (this.hits.length ? snhc.count(this.hits.length, "hit") : "nothing") : "";
  }

  step(by) {
    const bit = /^\[(\d+)/.exec(this.input.value.trim());
    if (bit) {
      this.select.bit(Number(bit[1]));
      return;
    }
    if (!this.hits.length) return;
    this.at = this.at < 0 ? (by > 0 ? 0 : this.hits.length - 1) : (this.at + by + this.hits.length) % this.hits.length;
    const row = this.hits[this.at];
    this.select({ part: this.stream.partOfRow(row), row, symbol: -1, bits: [this.stream.start[row], this.stream.end(row)] }, this);
    this.status.textContent = `${this.at + 1} of ${this.hits.length}`;
  }
};
