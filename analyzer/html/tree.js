"use strict";

// The syntax tree: items, planes, levels of the path, elements, symbols; only what is open is made.

// A node: kind (item, part, group, row, symbol, finding, error, gap), what it shows, its bits, and its children.
const node = (kind, label, level, more) => ({ kind, label, level, open: false, children: null, ...more });

snhc.Tree = class {
  constructor(stream, host, select) {
    this.stream = stream;
    this.host = host;
    this.select = select;
    this.selected = null;
    this.found = new Set();
    this.roots = this._roots();
    this.listing = new snhc.Listing(host, { height: 22, row: (index) => this._row(index) });
    this.flatten();
    host.addEventListener("click", (event) => this._click(event));
    host.addEventListener("keydown", (event) => this._key(event));
  }

  // -- nodes --

  _roots() {
    const stream = this.stream;
    const roots = [];
    this.partNodes = new Array(stream.partCount);
    let item = null;
    for (let part = 0; part < stream.partCount; part++) {
      if (stream.opens(part) || item === null || stream.parts.item[part] !== item.number) {
        const first = stream.parts.row[part];
        const name = stream.kindOfPart(part) || (first < stream.rowCount ? stream.element(first).name.replace("_start_code", "") : "stream");
        item = node("item", name, 1, { number: stream.parts.item[part], open: true, children: [], row: -1, part });
        roots.push(item);
      }
      if (stream.parts.plane[part] >= 0) {
        const plane = node("part", `plane[${stream.parts.plane[part]}]`, 2, { part, row: -1 });
        const before = [];
        for (let row = stream.parts.row[part]; row < stream.planeRow[part]; row++) before.push(node("row", stream.element(row).name, 2, { row, part }));
        this.partNodes[part] = [...before, plane];
        item.children.push(...before, plane);
      } else {
        const children = this._children(part, 2, stream.closes(part));
        this.partNodes[part] = children;
        item.children.push(...children);
      }
    }
    return roots;
  }

  // The rows of a part as a tree of its paths, with findings and the fault where they belong.
  _children(part, level, flat) {
    const stream = this.stream;
    const children = [];
    const open = [{ children, level: level - 1 }];
    let names = [];
    const pending = [...(stream.findingsOf.get(part) || [])].sort((a, b) => (a.bits ? a.bits[1] : 0) - (b.bits ? b.bits[1] : 0));
    const place = (upTo, into, depth) => {
      while (pending.length && (upTo === null || !pending[0].bits || pending[0].bits[1] <= upTo)) {
        const finding = pending.shift();
        into.push(node("finding", `${finding.severity} ${finding.id}: ${finding.message}`, depth, { finding, part, row: -1, bits: finding.bits }));
      }
    };
    const isPlane = stream.parts.plane[part] >= 0;
    for (let row = stream.planeRow[part]; row < stream.partEnd(part); row++) {
      const path = stream.data.paths[stream.rows.path[row]];
      const wanted = path && !flat ? path.split(".") : [];
      let shared = 0;
      while (shared < wanted.length && wanted[shared] === names[shared]) shared++;
      open.length = Math.min(open.length, shared + 1);
      for (const name of wanted.slice(shared)) {
        const group = node("group", name, open.at(-1).level + 1, { children: [], part, row, open: isPlane || stream.isFaulty(part) });
        open.at(-1).children.push(group);
        open.push(group);
      }
      names = wanted;
      const above = open.at(-1);
      const one = node("row", stream.element(row).name, above.level + 1, { row, part });
      const segment = stream.segmentOf(row);
      if (segment >= 0 && stream.labels(segment).length) one.segment = segment;
      above.children.push(one);
      place(stream.end(row), above.children, above.level + 1);
    }
    place(null, children, level);
    if (stream.isFaulty(part)) {
      const error = stream.data.error;
      children.push(node("error", error.message, level, { part, row: -1, bits: error.bits || null }));
      if (stream.data.unclaimed) {
        const [start, end] = stream.data.unclaimed;
        children.push(node("gap", `unclaimed: ${snhc.count(end - start, "bit")} from the fault to the end`, level, { part, row: -1, bits: [start, end] }));
      }
    }
    return children;
  }

  childrenOf(one) {
    if (one.children === null) {
      if (one.kind === "part") one.children = this._children(one.part, 3, false);
      else if (one.segment !== undefined) {
        const levels = this.stream.levels(one.segment);
        one.children = this.stream.labels(one.segment).map((label, symbol) =>
          node("symbol", label, one.level + 1, { row: one.row, part: one.part, symbol, value: levels[symbol], children: [] }));
      } else one.children = [];
    }
    return one.children;
  }

  isOpenable(one) {
    return one.kind === "part" || one.segment !== undefined || (one.children !== null && one.children.length > 0);
  }

  flatten() {
    this.visible = [];
    const take = (nodes) => {
      for (const one of nodes) {
        one.index = this.visible.length;
        this.visible.push(one);
        if (one.open) take(this.childrenOf(one));
      }
    };
    take(this.roots);
    this.listing.resize(this.visible.length);
  }

  toggle(one, open = !one.open) {
    if (!this.isOpenable(one) || one.open === open) return;
    one.open = open;
    this.flatten();
  }

  bitsOf(one) {
    if (one.bits !== undefined) return one.bits;
    if (one.kind === "row") return [this.stream.start[one.row], this.stream.end(one.row)];
    if (one.kind === "symbol") return this.stream.settled(this.stream.segmentOf(one.row))[one.symbol];
    if (one.kind === "part") return this.stream.span(one.part);
    if (one.kind === "group") {
      let last = one;
      while (last.children && last.children.length) last = last.children.findLast((child) => child.kind !== "finding");
      return [this.stream.start[one.row], this.stream.end(last.row)];
    }
    return null;
  }

  // -- what is seen --

  _row(index) {
    const one = this.visible[index];
    const stream = this.stream;
    const bits = this.bitsOf(one);
    const parts = [];
    if (one.kind === "row") {
      const words = stream.meaning(one.row);
      parts.push(snhc.make("span", { class: "eq" }, "="), snhc.make("span", { class: "value" }, stream.valueText(one.row)));
      if (words) parts.push(snhc.make("span", { class: "words" }, words));
      else if (one.segment !== undefined) parts.push(snhc.make("span", { class: "words" }, Array.from(stream.levels(one.segment).subarray(0, 24)).join(" ")));
    } else if (one.kind === "symbol") {
      parts.push(snhc.make("span", { class: "eq" }, "="), snhc.make("span", { class: "value" }, String(one.value)));
    } else if (one.kind === "part") {
      parts.push(snhc.make("span", { class: "words" }, snhc.planeWords(stream, one.part)));
    }
    const mark = one.kind === "finding" ? "▲" : one.kind === "error" ? "✖" : one.kind === "gap" ? "░" : this.isOpenable(one) ? (one.open ? "▾" : "▸") : "";
    const element = snhc.make("div", {
      id: `node-${index}`, role: "treeitem", "aria-level": one.level, "aria-selected": String(one === this.selected),
      "aria-expanded": this.isOpenable(one) ? String(one.open) : null, class: one.kind, "data-index": index,
    }, snhc.make("span", { class: "twist", "aria-hidden": "true" }, mark),
      snhc.make("span", { class: "label" }, one.label), ...parts,
      snhc.make("span", { class: "right" }, bits ? snhc.count(bits[1] - bits[0], "bit") : ""));
    element.style.paddingLeft = `${6 + (one.level - 1) * 15}px`;
    if (one.row >= 0 && one.kind === "row" && this.found.has(one.row)) element.classList.add("found");
    return element;
  }

  // -- selection --

  // Open what hides a row (or symbol, or the node of a plane) and show it; the tree selects, tells nobody.
  reveal({ part, row = -1, symbol = -1 }, scroll = true) {
    if (part < 0) return;
    const way = [];
    const find = (nodes) => {
      for (const one of nodes) {
        const hit = row < 0 ? one.kind === "part" : one.kind === "row" && one.row === row;
        if (hit && one.part === part) return one;
        if (one.kind === "group" || (one.kind === "part" && row >= 0)) {
          way.push(one);
          const below = find(this.childrenOf(one));
          if (below) return below;
          way.pop();
        }
      }
      return null;
    };
    let target = find(this.partNodes[part]);
    if (!target) return;
    const item = this.roots.findLast((root) => root.part <= part);
    for (const one of [item, ...way]) one.open = true;
    if (symbol >= 0 && target.segment !== undefined) {
      target.open = true;
      target = this.childrenOf(target)[symbol];
    }
    this.flatten();
    this.mark(target, scroll);
  }

  mark(one, scroll = true) {
    this.selected = one;
    if (one) {
      if (scroll) this.listing.scrollTo(one.index);
      this.host.setAttribute("aria-activedescendant", `node-${one.index}`);
    }
    this.listing.refresh();
  }

  choose(one) {
    this.mark(one);
    this.select({ part: one.part, row: one.kind === "group" ? -1 : one.row, symbol: one.symbol ?? -1, bits: this.bitsOf(one), node: one }, this);
  }

  _click(event) {
    const element = event.target.closest("[data-index]");
    if (!element) return;
    const one = this.visible[Number(element.dataset.index)];
    if (event.target.closest(".twist") || (one === this.selected && this.isOpenable(one))) this.toggle(one);
    this.choose(one);
  }

  _key(event) {
    const now = this.selected ? this.selected.index : -1;
    const to = { ArrowDown: now + 1, ArrowUp: now - 1, Home: 0, End: this.visible.length - 1, PageDown: now + this.listing.page, PageUp: now - this.listing.page }[event.key];
    if (to !== undefined) {
      this.choose(this.visible[Math.max(0, Math.min(this.visible.length - 1, to))]);
    } else if (event.key === "ArrowRight" && this.selected) {
      if (this.isOpenable(this.selected) && !this.selected.open) {
        this.toggle(this.selected);
        this.mark(this.selected);
      } else if (this.selected.open) this.choose(this.visible[now + 1]);
    } else if (event.key === "ArrowLeft" && this.selected) {
      if (this.selected.open) {
        this.toggle(this.selected);
        this.mark(this.selected);
      } else {
        for (let i = now - 1; i >= 0; i--) {
          if (this.visible[i].level < this.selected.level) {
            this.choose(this.visible[i]);
            break;
          }
        }
      }
    } else if ((event.key === "Enter" || event.key === " ") && this.selected) {
      this.toggle(this.selected);
      this.mark(this.selected);
    } else return;
    event.preventDefault();
  }
};

snhc.planeWords = (stream, part) => {
  const mask = stream.parts.mask[part];
  const data = mask & 4 ? "geometry" : mask & 8 ? "motion" : mask === 3 ? "FAPs, BAPs" : mask === 2 ? "BAPs" : mask === 1 ? "FAPs" : "no data";
  const time = stream.time(part);
  return `${stream.isIntra(part) ? "intra" : "inter"}, ${data}${time === null ? "" : `, ${time.toFixed(3)} s`}`;
};
