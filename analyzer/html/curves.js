"use strict";

// FAP curves over time; the selected plane is a line, the selected FAPs are heavy.

const SHOWN_AT_FIRST = 6;
const COMPACT = new Intl.NumberFormat("en", { notation: "compact", maximumSignificantDigits: 3 });
const HUES = [212, 28, 152, 330, 265, 48, 190, 0, 100, 240];

snhc.Curves = class {
  constructor(stream, canvas, list, select) {
    this.stream = stream;
    this.canvas = canvas;
    this.list = list;
    this.select = select;
    this.frame = 0;
    this.strong = new Set();
    const { faps } = stream.face;
    this.order = [...faps.keys()];
    const range = (column) => {
      let low = Infinity;
      let high = -Infinity;
      for (const value of column) {
        if (value === snhc.UNSET) continue;
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
      return high - low;
    };
    const lively = [...this.order].sort((a, b) => range(faps.get(b)) - range(faps.get(a)));
    this.shown = new Set(lively.slice(0, SHOWN_AT_FIRST));
    // Those that are shown at first stand at the top of the list.
    this.order = [...lively.slice(0, SHOWN_AT_FIRST), ...this.order.filter((fap) => !this.shown.has(fap))];
    this.colours = new Map(lively.map((fap, i) => [fap, HUES[i % HUES.length]]));
    this.frameOfPart = stream.parts.frame;
    this._place();
    this._fill();
    canvas.addEventListener("click", (event) => {
      const box = canvas.getBoundingClientRect();
      this._choose(this._frameAt(event.clientX - box.left, box.width));
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1, Home: -Infinity, End: Infinity }[event.key];
      if (step === undefined) return;
      this._choose(Math.max(0, Math.min(stream.face.time.length - 1, this.frame + step)));
      event.preventDefault();
    });
    new ResizeObserver(() => this.paint()).observe(canvas);
  }

  // Where frames stand on the axis: objects one after another, each has a clock of its own.
  _place() {
    const { time } = this.stream.face;
    this.begins = new Set();
    let isNew = false;
    for (let part = 0; part < this.stream.partCount; part++) {
      if (this.stream.kindOfPart(part) !== "fba_object") continue;
      isNew = isNew || this.stream.opens(part);
      if (!isNew || !this.stream.parts.frames[part]) continue;
      if (this.frameOfPart[part] > 0) this.begins.add(this.frameOfPart[part]);
      isNew = false;
    }
    this.axis = Float64Array.from(time);
    let shift = 0;
    for (let frame = 1; frame < time.length; frame++) {
      if (this.begins.has(frame)) shift = this.axis[frame - 1] + (frame > 1 ? time[frame - 1] - time[frame - 2] : 0) - time[frame];
      this.axis[frame] = time[frame] + shift;
    }
  }

  _fill() {
    const { data } = this.stream;
    this.now = new Map();
    this.list.replaceChildren(...this.order.map((fap) => {
      const box = snhc.make("input", { type: "checkbox", onchange: () => { box.checked ? this.shown.add(fap) : this.shown.delete(fap); this.paint(); } });
      box.checked = this.shown.has(fap);
      const now = snhc.make("span", { class: "now" });
      const swatch = snhc.make("span", { class: "swatch", "aria-hidden": "true" });
      this.now.set(fap, { now, swatch, box });
      return snhc.make("label", {}, box, swatch, snhc.make("span", { class: "name" }, `${fap} ${data.faps[fap].name}`), now);
    }));
  }

  line(fap) { return `hsl(${this.colours.get(fap)} ${snhc.isDark() ? "75% 68%" : "70% 40%"})`; }

  _frameAt(x, width) {
    const first = this.axis[0];
    const last = this.axis[this.axis.length - 1];
    const wanted = first + (Math.max(0, x - 44) / Math.max(1, width - 54)) * (last - first);
    return Math.max(0, snhc.lastAtMost(this.axis, wanted + 1e-9));
  }

  _choose(frame) {
    // The plane that made the frame: the last one that begins at or before it.
    let best = -1;
    for (const part of this.stream.planes) {
      if (this.stream.kindOfPart(part) !== "fba_object") continue;
      const first = this.frameOfPart[part];
      if (first <= frame && frame < first + this.stream.parts.frames[part]) best = part;
    }
    if (best >= 0) this.select({ part: best, row: -1, symbol: -1, bits: this.stream.span(best), frame }, null);
  }

  show(frame, faps) {
    this.frame = frame;
    this.strong = new Set(faps.filter((fap) => this.colours.has(fap)));
    if (this.strong.size <= 12) for (const fap of this.strong) this.shown.add(fap);
    this.paint();
  }

  paint() {
    const { time, faps } = this.stream.face;
    for (const [fap, { now, swatch, box }] of this.now) {
      const value = faps.get(fap)[this.frame];
      now.textContent = value === snhc.UNSET || value === undefined ? "–" : String(value);
      box.checked = this.shown.has(fap);
      swatch.style.setProperty("--colour", this.shown.has(fap) ? this.line(fap) : "var(--line)");
    }
    const drawn = this.order.filter((fap) => this.shown.has(fap));
    this.canvas.setAttribute("aria-label", `FAP curves over ${snhc.count(time.length, "frame")}: ` + drawn.map((fap) => `${fap} ${this.stream.data.faps[fap].name} ${this.now.get(fap).now.textContent}`).join(", "));
    snhc.draw(this.canvas, (context, width, height) => {
      const [left, right, top, bottom] = [44, width - 10, 10, height - 22];
      let low = 0;
      let high = 1;
      for (const fap of drawn) {
        for (const value of faps.get(fap)) {
          if (value === snhc.UNSET) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
      const first = this.axis[0];
      const length = this.axis[time.length - 1] - first || 1;
      const x = (frame) => left + ((this.axis[frame] - first) / length) * (right - left);
      const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - top);
      this._axes(context, { left, right, top, bottom, low, high, first, length, y });
      context.lineJoin = "round";
      // Not more points than pixels can show: of a run of frames the lowest and the highest.
      const step = Math.max(1, Math.floor(time.length / (2 * (right - left))));
      for (const fap of drawn) {
        const column = faps.get(fap);
        context.strokeStyle = this.line(fap);
        context.lineWidth = this.strong.has(fap) ? 2.6 : 1.3;
        context.globalAlpha = this.strong.size && !this.strong.has(fap) ? 0.35 : 1;
        context.beginPath();
        let pen = false;
        for (let frame = 0; frame < time.length; frame += step) {
          let [least, most] = [Infinity, -Infinity];
          for (let k = frame; k < Math.min(frame + step, time.length); k++) {
            if (column[k] === snhc.UNSET) continue;
            least = Math.min(least, column[k]);
            most = Math.max(most, column[k]);
          }
          for (let k = frame; k < frame + step; k++) if (this.begins.has(k)) pen = false;
          if (least === Infinity) { pen = false; continue; }
          if (pen) context.lineTo(x(frame), y(least));
          else context.moveTo(x(frame), y(least));
          if (most !== least) context.lineTo(x(frame), y(most));
          pen = true;
        }
        context.stroke();
      }
      context.globalAlpha = 1;
      context.lineWidth = 1;
      context.strokeStyle = snhc.colour("soft");
      context.setLineDash([4, 4]);
      for (const frame of this.begins) {
        context.beginPath();
        context.moveTo(x(frame), top);
        context.lineTo(x(frame), bottom);
        context.stroke();
      }
      context.setLineDash([]);
      context.strokeStyle = snhc.colour("accent");
      context.beginPath();
      context.moveTo(x(this.frame), top);
      context.lineTo(x(this.frame), bottom);
      context.stroke();
    });
  }

  _axes(context, { left, right, top, bottom, low, high, first, length, y }) {
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = snhc.colour("soft");
    context.strokeStyle = snhc.colour("line");
    context.lineWidth = 1;
    const raw = (high - low) / 4;
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((one) => one * power).find((one) => one >= raw);
    context.textAlign = "right";
    for (let value = Math.ceil(low / step) * step; value <= high; value += step) {
      context.beginPath();
      context.moveTo(left, y(value));
      context.lineTo(right, y(value));
      context.stroke();
      context.fillText(COMPACT.format(value), left - 6, y(value) + 4);
    }
    context.textAlign = "center";
    for (let k = 0; k <= 4; k++) {
      const at = left + (k / 4) * (right - left);
      context.textAlign = k === 4 ? "right" : k === 0 ? "left" : "center";
      const on = first + (k / 4) * length;
      // Of several objects each says its own time.
      const said = this.begins.size ? this.stream.face.time[Math.max(0, snhc.lastAtMost(this.axis, on + 1e-9))] : on;
      context.fillText(`${said.toFixed(2)} s`, at, bottom + 15);
    }
  }
};
