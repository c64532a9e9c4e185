"use strict";

// One selection, shown by all panels. The address keeps it, so that a place in a stream can be passed on.

snhc.App = class {
  constructor(data) {
    const stream = new snhc.Stream(data);
    this.stream = stream;
    const select = (what, by) => this.select(what, by);
    select.bit = (bit) => this.hex.choose(bit);
    this._title();
    this._theme();
    this.tree = new snhc.Tree(stream, snhc.byId("tree"), select);
    this.hex = new snhc.HexView(stream, snhc.byId("hex"), snhc.byId("strip"), snhc.byId("place"), select);
    this.planes = new snhc.Planes(stream, snhc.byId("plane-list"), snhc.byId("skyline"), select);
    this.details = new snhc.Details(stream, snhc.byId("about"));
    this._views(select);
    this.search = new snhc.Search(stream, snhc.byId("query"), snhc.byId("found"), this.tree, select);
    this._faults();
    this._keys();
    this._start();
  }

  _title() {
    const { data } = this.stream;
    document.title = `${data.name} – snhc`;
    snhc.byId("name").textContent = data.name;
    const readings = Object.entries(data.readings).map(([id, key]) => `${id}=${key}`);
    const words = [snhc.count(data.size, "byte"), snhc.count(this.stream.planes.length, "plane"), snhc.count(this.stream.rowCount, "element")];
    if (data.selected) words.push("selected planes only");
    snhc.byId("summary").textContent = [...words, ...readings].join(" · ");
  }

  _theme() {
    const root = document.documentElement;
    const asked = window.matchMedia("(prefers-color-scheme: dark)");
    const button = snhc.byId("theme");
    const apply = (theme) => {
      root.dataset.theme = theme;
      button.textContent = theme === "dark" ? "☀" : "☾";
      button.setAttribute("aria-label", theme === "dark" ? "Light colours" : "Dark colours");
      this.repaint();
    };
    let chosen = false;
    asked.addEventListener("change", () => { if (!chosen) apply(asked.matches ? "dark" : "light"); });
    button.addEventListener("click", () => {
      chosen = true;
      apply(snhc.isDark() ? "light" : "dark");
    });
    apply(asked.matches ? "dark" : "light");
    snhc.byId("help").addEventListener("click", () => snhc.byId("keys").showModal());
  }

  repaint() {
    for (const panel of [this.planes, this.head, this.curves, this.mesh]) if (panel) panel.paint();
  }

  _views(select) {
    const { stream } = this;
    this.panels = [];
    if (stream.face) {
      this.head = new snhc.HeadView(stream, snhc.byId("head"), snhc.byId("head-words"));
      this.curves = new snhc.Curves(stream, snhc.byId("curves"), snhc.byId("curve-list"), select);
      this.panels.push(["head", "Head"], ["curves", "FAP curves"]);
    }
    if (stream.mesh) {
      this.mesh = new snhc.MeshView(stream, snhc.byId("mesh"), snhc.byId("mesh-words"), select);
      this.panels.push(["mesh", "Mesh"]);
    }
    snhc.byId("views").hidden = !this.panels.length;
    const tabs = snhc.byId("tabs");
    const open = (id, focus) => {
      for (const [name] of this.panels) {
        const on = name === id;
        const tab = snhc.byId(`${name}-tab`);
        tab.setAttribute("aria-selected", String(on));
        tab.tabIndex = on ? 0 : -1;
        snhc.byId(`${name}-panel`).hidden = !on;
        if (on && focus) tab.focus();
      }
      this.repaint();
    };
    this.openView = open;
    tabs.replaceChildren(...this.panels.map(([id, words]) => snhc.make("button", {
      type: "button", role: "tab", id: `${id}-tab`, "aria-controls": `${id}-panel`, onclick: () => open(id, false),
    }, words)));
    tabs.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      const now = this.panels.findIndex(([id]) => snhc.byId(`${id}-tab`).getAttribute("aria-selected") === "true");
      open(this.panels[(now + step + this.panels.length) % this.panels.length][0], true);
    });
    if (this.panels.length) open(this.panels[0][0], false);
  }

  // -- what is wrong with the stream --

  _faults() {
    const { stream } = this;
    this.faults = [];
    for (const [part, findings] of stream.findingsOf) for (const finding of findings) this.faults.push({ part, finding });
    if (stream.data.error) this.faults.push({ part: stream.partCount - 1, finding: null });
    const button = snhc.byId("fault");
    if (!this.faults.length) return;
    const findings = this.faults.length - (stream.data.error ? 1 : 0);
    button.hidden = false;
    button.textContent = [stream.data.error ? `✖ ${stream.data.error.class}` : "", findings ? `▲ ${snhc.count(findings, "finding")}` : ""].filter(Boolean).join("  ");
    button.classList.toggle("mild", !stream.data.error);
    button.setAttribute("aria-label", `${button.textContent.replace(/[✖▲]/g, "")}: go to the next`);
    this.fault = -1;
    button.addEventListener("click", () => this.nextFault());
  }

  nextFault() {
    if (!this.faults.length) return;
    // The fault comes first: it is why most people open the page.
    this.fault = this.fault < 0 && this.stream.data.error ? this.faults.length - 1 : (this.fault + 1) % this.faults.length;
    const { part, finding } = this.faults[this.fault];
    const ofPart = this.tree.partNodes[part];
    const find = (nodes, way) => {
      for (const one of nodes) {
        if (finding ? one.finding === finding : one.kind === "error") return [...way, one];
        if (one.kind === "part" || one.kind === "group") {
          const below = find(this.tree.childrenOf(one), [...way, one]);
          if (below) return below;
        }
      }
      return null;
    };
    const way = find(ofPart, []);
    if (!way) return;
    for (const one of way.slice(0, -1)) one.open = true;
    this.tree.roots.findLast((root) => root.part <= part).open = true;
    this.tree.flatten();
    this.tree.choose(way.at(-1));
  }

  // -- selection --

  select({ part, row = -1, symbol = -1, bit = -1, bits = null, node = null, frame = -1 }, by) {
    const { stream } = this;
    if (bits === null && row >= 0) {
      bits = symbol >= 0 ? stream.settled(stream.segmentOf(row))[symbol] : [stream.start[row], stream.end(row)];
      // The two bits that end a segment belong to no symbol.
      const segment = stream.segmentOf(row);
      if (segment >= 0 && symbol < 0 && bit >= stream.end(row) - 2) bits = [stream.end(row) - 2, stream.end(row)];
    }
    if (bits === null && bit >= 0) bits = stream.data.unclaimed && bit >= stream.data.unclaimed[0] ? stream.data.unclaimed : [bit, bit + 1];
    const what = { part, row, symbol, bit: bit >= 0 ? bit : bits ? bits[0] : -1, bits, node };
    this.selected = what;
    if (by !== this.tree) {
      if (part >= 0) this.tree.reveal(what);
      else this.tree.mark(null);
    }
    this.hex.show(bits, what.bit, by !== this.hex || bit >= 0);
    if (part >= 0 && stream.parts.plane[part] >= 0 && this.planes.selected !== stream.planes.indexOf(part)) this.planes.show(part);
    this.details.show(what);
    this._picture(part, row, symbol, frame);
    if (what.bit >= 0) history.replaceState(null, "", `#bit=${what.bit}`);
  }

  _picture(part, row, symbol, frame) {
    const { stream } = this;
    if (part < 0 || !stream.parts.frames[part]) return;
    const first = frame >= 0 ? frame : stream.parts.frame[part];
    if (this.mesh && stream.kindOfPart(part) === "mesh_object") this.mesh.show(part, first, stream.nodeOf(row));
    else if (this.head) {
      const faps = stream.fapsOf(row, symbol);
      const all = row >= 0 && stream.segmentOf(row) >= 0 && symbol < 0;
      this.head.show(first, all ? [] : faps);
      this.curves.show(first, all ? [] : faps);
    }
  }

  _keys() {
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("input, textarea") || snhc.byId("keys").open) return;
      if (event.key === "/") snhc.byId("query").focus();
      else if (event.key === "[" || event.key === "]") this.planes.choose(this.planes.selected + (event.key === "]" ? 1 : -1));
      else if (event.key === "e") this.nextFault();
      else if (event.key === "?") snhc.byId("keys").showModal();
      else return;
      event.preventDefault();
    });
    window.addEventListener("hashchange", () => this._start());
  }

  _start() {
    const { stream } = this;
    const bit = /^#bit=(\d+)$/.exec(location.hash);
    if (bit && Number(bit[1]) >= stream.firstBit && Number(bit[1]) < stream.endBit) {
      if (!this.selected || this.selected.bit !== Number(bit[1])) this.hex.choose(Number(bit[1]));
    } else if (stream.planes.length) this.planes.choose(0);
    else this.details.show({ part: -1, row: -1, symbol: -1, bits: null, node: null });
    if (stream.planes.length && this.tree.selected && this.tree.selected.kind === "part") this.tree.toggle(this.tree.selected, true);
  }
};

snhc.app = new snhc.App(JSON.parse(document.getElementById("snhc-data").textContent));
