"use strict";

// A list of any length of which only the rows in sight are in the document.

// Browsers do not lay out higher boxes than some ten million pixels.
const HIGHEST = 8e6;

snhc.Listing = class {
  // `row(index)`: the element of a row, which gets its place here.
  constructor(host, { height, row }) {
    this.host = host;
    this.height = height;
    this.row = row;
    this.length = 0;
    this.made = 0; // rows made so far: what the tests bound
    this.sizer = snhc.make("div", { class: "sizer", role: "presentation" });
    host.append(this.sizer);
    host.addEventListener("scroll", () => this.refresh(), { passive: true });
    new ResizeObserver(() => this.refresh()).observe(host);
  }

  resize(length) {
    this.length = length;
    this.full = length * this.height;
    this.sizer.style.height = `${Math.min(this.full, HIGHEST)}px`;
    this.refresh();
  }

  get page() { return Math.max(1, Math.floor(this.host.clientHeight / this.height)); }

  // Pixels from the top of the whole list that are at the top of the window.
  get offset() {
    const shown = Math.min(this.full, HIGHEST);
    const room = shown - this.host.clientHeight;
    return this.full <= HIGHEST || room <= 0 ? this.host.scrollTop : (this.host.scrollTop / room) * (this.full - this.host.clientHeight);
  }

  scrollTo(index) {
    const top = index * this.height;
    const offset = this.offset;
    if (top >= offset + this.height && top + 2 * this.height <= offset + this.host.clientHeight) return;
    if (index === 0 && offset === 0) return;
    const wanted = Math.max(0, top - this.host.clientHeight / 3);
    const shown = Math.min(this.full, HIGHEST);
    this.host.scrollTop =
      this.full <= HIGHEST ? wanted : (wanted / (this.full - this.host.clientHeight)) * (shown - this.host.clientHeight);
  }

  refresh() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  render() {
    const offset = this.offset;
    const first = Math.max(0, Math.floor(offset / this.height) - 2);
    const last = Math.min(this.length, first + this.page + 5);
    const base = this.host.scrollTop - offset;
    const rows = [];
    for (let index = first; index < last; index++) {
      const element = this.row(index);
      element.classList.add("row");
      element.style.height = `${this.height}px`;
      element.style.top = `${base + index * this.height}px`;
      rows.push(element);
      this.made++;
    }
    this.sizer.replaceChildren(...rows);
  }
};
