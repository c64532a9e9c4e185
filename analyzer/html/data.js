"use strict";

// The stream as columns: which row a bit belongs to, what rows and symbols are called, what planes there are.

const FAULT = 8, INTRA = 4, CLOSES = 2, OPENS = 1;
const CODE_NAMES = /_code$|^stuffing$|^object_stuffing$/;

snhc.Stream = class {
  constructor(data) {
    this.data = data;
    this.bytes = snhc.decodeBase64(data.bytes);
    this.firstBit = data.firstByte * 8;
    this.elements = data.elements;
    const unpackAll = (columns) => Object.fromEntries(Object.entries(columns).map(([name, text]) => [name, snhc.unpack(text)]));
    this.rows = unpackAll(data.rows);
    this.parts = unpackAll(data.parts);
    this.segments = unpackAll(data.segments);
    this.symbols = unpackAll(data.symbols);
    this.rowCount = this.rows.element.length;
    this.partCount = this.parts.row.length;
    this.blobs = new Set(this.rows.blobs);
    this._placeRows();
    this._placeSymbols();
    this.kinds = this.elements.map((element) => this._kind(element.name));
    this.planes = [];
    for (let part = 0; part < this.partCount; part++) if (this.parts.plane[part] >= 0) this.planes.push(part);
    this.findingsOf = new Map();
    for (const [part, bits, severity, id, rule, message] of data.findings) {
      if (!this.findingsOf.has(part)) this.findingsOf.set(part, []);
      this.findingsOf.get(part).push({ bits, severity, id, rule, message });
    }
  }

  _placeRows() {
    // A row starts where the one before it in its part ends.
    const { row, start } = this.parts;
    this.start = new Float64Array(this.rowCount);
    for (let part = 0; part < this.partCount; part++) {
      let at = start[part];
      for (let r = row[part], end = this.partEnd(part); r < end; r++) {
        this.start[r] = at;
        at += this.rows.width[r];
      }
    }
    // The start code of the object comes with the first plane, and is not of it.
    const root = this.data.paths.indexOf("/");
    this.planeRow = Uint32Array.from(row);
    for (let part = 0; part < this.partCount; part++) {
      while (this.planeRow[part] < this.partEnd(part) && this.rows.path[this.planeRow[part]] === root) this.planeRow[part]++;
    }
  }

  _placeSymbols() {
    this.symbolFirst = new Uint32Array(this.segments.row.length + 1);
    this.segments.labels.forEach((set, segment) => {
      this.symbolFirst[segment + 1] = this.symbolFirst[segment] + this.data.labelSets[set].length;
    });
    this.guards = new Map();
    this.segments.guardSegment.forEach((segment, i) => {
      if (!this.guards.has(segment)) this.guards.set(segment, []);
      this.guards.get(segment).push(this.segments.guard[i]);
    });
  }

  _kind(name) {
    if (CODE_NAMES.test(name)) return "code";
    if (/mask|minmax|_new_|marker/.test(name)) return "mask";
    if (/segment|dc|ac|run|level|delta|node|vlc|_def$|select|intensity|blend|init_face/.test(name)) return "data";
    if (/user_data|trailing|padding/.test(name)) return "bytes";
    return "head";
  }

  partEnd(part) { return part + 1 < this.partCount ? this.parts.row[part + 1] : this.rowCount; }
  partOfRow(row) { return snhc.lastAtMost(this.parts.row, row); }
  isIntra(part) { return (this.parts.flags[part] & INTRA) !== 0; }
  opens(part) { return (this.parts.flags[part] & OPENS) !== 0; }
  closes(part) { return (this.parts.flags[part] & CLOSES) !== 0; }
  isFaulty(part) { return (this.parts.flags[part] & FAULT) !== 0; }
  kindOfPart(part) { return this.data.kinds[this.parts.kind[part]]; }
  end(row) { return this.start[row] + this.rows.width[row]; }

  span(part) {
    const first = this.planeRow[part];
    const end = this.partEnd(part);
    return first < end ? [this.start[first], this.end(end - 1)] : [0, 0];
  }

  // The bits of a plane, start code and stuffing before it included.
  planeBits(part) {
    const [start, end] = this.span(part);
    return end - start;
  }

  rowAt(bit) {
    const row = snhc.lastAtMost(this.start, bit);
    return row >= 0 && bit < this.end(row) ? row : -1;
  }

  element(row) { return this.elements[this.rows.element[row]]; }
  kindOfRow(row) { return this.kinds[this.rows.element[row]]; }

  path(row) {
    const below = this.data.paths[this.rows.path[row]];
    if (below === "/") return "";
    const plane = this.parts.plane[this.partOfRow(row)];
    return plane < 0 ? below : below ? `plane[${plane}].${below}` : `plane[${plane}]`;
  }

  segmentOf(row) {
    const segment = snhc.lastAtMost(this.segments.row, row);
    return segment >= 0 && this.segments.row[segment] === row ? segment : -1;
  }

  labels(segment) { return this.data.labelSets[this.segments.labels[segment]]; }

  levels(segment) { return this.symbols.level.subarray(this.symbolFirst[segment], this.symbolFirst[segment + 1]); }

  // For each symbol the bits that it settles (elements.py: settled_bits).
  settled(segment) {
    if (this._settled && this._settled.segment === segment) return this._settled.spans;
    const start = this.start[this.segments.row[segment]];
    const before = (this.guards.get(segment) || []).map((position, i) => position - start - i);
    const place = (bit) => start + bit + snhc.lastAtMost(before, bit) + 1;
    const spans = [];
    let done = 0;
    let at = start;
    for (let i = this.symbolFirst[segment]; i < this.symbolFirst[segment + 1]; i++) {
      const shifts = this.symbols.shifts[i];
      done += shifts;
      const end = shifts ? place(done - 1) + 1 : at;
      spans.push([at, end]);
      at = end;
    }
    this._settled = { segment, spans };
    return spans;
  }

  symbolAt(segment, bit) {
    return this.settled(segment).findIndex(([start, end]) => bit >= start && bit < end);
  }

  isCode(row) { return this.rows.width[row] === 32 && /_code$/.test(this.element(row).name); }

  valueText(row) {
    const value = this.rows.value[row];
    const width = this.rows.width[row];
    const segment = this.segmentOf(row);
    if (segment >= 0) return snhc.count(this.levels(segment).length, "symbol");
    if (this.blobs.has(row)) return snhc.count(width / 8, "byte");
    if (width > 64) return snhc.count(width, "bit");
    return this.isCode(row) ? "0x" + value.toString(16).padStart(8, "0") : String(value);
  }

  meaning(row) { return this.segmentOf(row) >= 0 || this.blobs.has(row) ? "" : this.element(row).meaning[this.rows.value[row]] || ""; }

  bit(position) {
    const at = position - this.firstBit;
    return (this.bytes[at >> 3] >> (7 - (at & 7))) & 1;
  }

  bitsText(start, end, most = 256) {
    let text = "";
    for (let bit = start; bit < Math.min(end, start + most); bit++) text += this.bit(bit);
    return end - start > most ? text + "…" : text;
  }

  get endBit() { return this.firstBit + this.bytes.length * 8; }

  // -- frames --

  time(part) {
    const source = this.kindOfPart(part) === "mesh_object" ? this.mesh : this.face;
    return source && this.parts.frames[part] ? source.time[this.parts.frame[part]] : null;
  }

  get face() {
    if (this._face === undefined) {
      const face = this.data.face;
      const all = (columns) => new Map(Object.entries(columns || {}).map(([fap, text]) => [Number(fap), snhc.unpack(text)]));
      this._face = face && {
        time: snhc.unpack(face.time),
        faps: all(face.faps),
        pose: face.pose ? all(face.pose) : null,
        visemes: face.visemes && snhc.unpack(face.visemes),
        expressions: face.expressions && snhc.unpack(face.expressions),
      };
    }
    return this._face;
  }

  get mesh() {
    if (this._mesh === undefined) {
      const mesh = this.data.mesh;
      this._mesh = mesh && {
        time: snhc.unpack(mesh.time), nodes: snhc.unpack(mesh.nodes), first: snhc.unpack(mesh.first),
        geometry: snhc.unpack(mesh.geometry),
        meshes: mesh.meshes.map((one) => ({ triangles: snhc.unpack(one.triangles), order: snhc.unpack(one.order) })),
      };
    }
    return this._mesh;
  }

  // The FAPs that a selection speaks of.
  fapsOf(row, symbol) {
    if (row < 0 || !this.face) return [];
    const segment = this.segmentOf(row);
    if (segment >= 0) {
      const labels = this.labels(segment);
      return (symbol >= 0 ? [labels[symbol]] : labels).map(this._fapOfLabel).filter((fap) => fap > 0);
    }
    const path = this.data.paths[this.rows.path[row]];
    const group = /^fap\.group\[(\d+)\]/.exec(path);
    if (group) {
      const [first, last] = this.data.groups[group[1]];
      return Array.from({ length: last - first + 1 }, (_, i) => first + i);
    }
    const single = /^fap\.fap\[(\d+)\]/.exec(path);
    if (single) return [Number(single[1])];
    return /^fap\.new_minmax\[/.test(path) ? this._fapOfLimit(row) : [];
  }

  _fapOfLabel(label) {
    const match = /^FAP (\d+)/.exec(label);
    return match ? Number(match[1]) : label.startsWith("viseme") ? 1 : label.startsWith("expression") ? 2 : 0;
  }

  // A list of ranges has a value for each low-level FAP that the plane codes, in the order in which it codes them.
  _fapOfLimit(row) {
    const name = this.rows.element[row];
    let number = 0;
    let other = row;
    for (; this.rows.path[other] === this.rows.path[row]; other--) number += this.rows.element[other] === name;
    // Between the values are markers; `other` is the flag before the list.
    if (!/_new_/.test(this.element(row).name)) return [];
    const coded = [];
    for (let at = row; at < this.partEnd(this.partOfRow(row)); at++) {
      const segment = this.segmentOf(at);
      const single = segment < 0 && /^fap\.fap\[(\d+)\]/.exec(this.data.paths[this.rows.path[at]]);
      if (segment >= 0) coded.push(...this.labels(segment).map(this._fapOfLabel));
      else if (single) coded.push(Number(single[1]));
    }
    const faps = [...new Set(coded)].filter((fap) => fap > 2);
    return number <= faps.length ? [faps[number - 1]] : [];
  }

  // The mesh node that a row speaks of, or -1.
  nodeOf(row) {
    const match = row >= 0 && /node\[(\d+)\]/.exec(this.data.paths[this.rows.path[row]]);
    return match ? Number(match[1]) : -1;
  }
};

snhc.UNSET = -2147483648;
