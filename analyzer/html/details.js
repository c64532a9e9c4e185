"use strict";

// What is selected: name, value, meaning, bits, and the rule that says so.

snhc.Details = class {
  constructor(stream, host) {
    this.stream = stream;
    this.host = host;
  }

  show({ part, row, symbol, bits, node }) {
    const stream = this.stream;
    const out = [];
    const special = node && ["finding", "error", "gap"].includes(node.kind) ? node : null;
    if (special) out.push(...this._special(special));
    else if (row >= 0) out.push(...this._row(row, symbol, bits));
    else if (node && node.kind === "group") out.push(...this._group(node, bits));
    else if (part >= 0 && stream.parts.plane[part] >= 0) out.push(...this._plane(part));
    else if (node) out.push(snhc.make("h3", {}, node.label));
    else if (bits) out.push(...this._unclaimed(bits));
    if (!out.length) out.push(snhc.make("p", {}, "Select an element, a bit or a plane."));
    if (!special && stream.data.error && part >= 0 && stream.isFaulty(part)) out.push(this._alarm(stream.data.error.message));
    if (row >= 0 && !special) {
      for (const finding of stream.findingsOf.get(part) || []) {
        if (finding.bits && finding.bits[0] < stream.end(row) && finding.bits[1] > stream.start[row]) {
          out.push(this._alarm(`${finding.severity} ${finding.id}: ${finding.message} (${finding.rule})`, "mild"));
        }
      }
    }
    this.host.replaceChildren(...out);
    this.host.scrollTop = 0;
  }

  _alarm(text, mild = "") { return snhc.make("p", { class: `alarm ${mild}` }, text); }

  _list(pairs) {
    return snhc.make("dl", {}, ...pairs.filter(([, value]) => value !== null && value !== "").flatMap(([name, value]) => [
      snhc.make("dt", {}, name), snhc.make("dd", { class: typeof value === "string" && /^[[01]/.test(value) ? "mono" : "" }, value),
    ]));
  }

  _row(row, symbol, bits) {
    const stream = this.stream;
    const element = stream.element(row);
    const segment = stream.segmentOf(row);
    const [start, end] = [stream.start[row], stream.end(row)];
    const out = [];
    if (symbol >= 0) {
      const span = stream.settled(segment)[symbol];
      out.push(snhc.make("h3", {}, stream.labels(segment)[symbol]),
        snhc.make("div", { class: "big" }, String(stream.levels(segment)[symbol]), snhc.make("small", {}, "  level")),
        this._list([
          ["symbol", `${symbol + 1} of ${stream.labels(segment).length} in ${element.name}`], ["path", stream.path(row)],
          ["settles", span[0] < span[1] ? `[${span[0]}, ${span[1]})` : "no bit of its own"],
          ["bits", span[0] < span[1] ? stream.bitsText(span[0], span[1]) : null], ...this._fap(stream.fapsOf(row, symbol)[0]),
        ]), ...this._coder(segment, symbol), ...this.rule("FBA-23"));
      return out;
    }
    const words = stream.meaning(row);
    out.push(snhc.make("h3", {}, element.name),
      snhc.make("div", { class: "big" }, stream.valueText(row), words ? snhc.make("small", {}, `  ${words}`) : null),
      this._list([
        ["path", stream.path(row)], ["bits", `[${start}, ${end})`], ["width", snhc.count(end - start, "bit")],
        ["raw", end > start ? stream.bitsText(start, end, 96) : null], ["allowed", element.allowed || null],
        ["levels", segment >= 0 ? Array.from(stream.levels(segment)).join(" ") : null],
        ["guards", segment >= 0 && stream.guards.has(segment) ? stream.guards.get(segment).map(Math.floor).join(", ") : null],
        ["text", stream.blobs.has(row) ? this._text(start, end) : null],
        ...this._fap(segment < 0 && stream.fapsOf(row, -1).length === 1 ? stream.fapsOf(row, -1)[0] : 0),
      ]));
    if (bits && segment >= 0 && bits[0] === end - 2 && bits[1] === end) {
      out.push(snhc.make("p", {}, "These two bits end the segment (FBA-26)."));
    }
    out.push(...this.rule(element.rule));
    return out;
  }

  _text(start, end) {
    const first = (start - this.stream.firstBit) / 8;
    const bytes = this.stream.bytes.subarray(first, Math.min(first + 400, (end - this.stream.firstBit) / 8));
    return Array.from(bytes, (byte) => (byte >= 32 && byte < 127 ? String.fromCharCode(byte) : "·")).join("");
  }

  _fap(fap) {
    const info = fap && this.stream.data.faps && this.stream.data.faps[fap];
    return info ? [["FAP", `${fap} ${info.name}`], ["unit", info.unit === "na" ? null : `${info.unit}, positive: ${info.motion}`], ["base step", info.unit === "na" ? null : String(info.step)]] : [];
  }

  _coder(segment, symbol) {
    const { symbols } = this.stream;
    if (!symbols.low) return [];
    const i = this.stream.symbolFirst[segment] + symbol;
    const flags = symbols.flags[i];
    const rows = [["low", symbols.low[i]], ["high", symbols.high[i]], ["code", symbols.code[i]], ["c", symbols.c[i]],
      ["bin", `[${symbols.cumLow[i]}, ${symbols.cumHigh[i]})`], ["total", symbols.total[i]], ["shifts", symbols.shifts[i]]];
    return [snhc.make("table", {}, snhc.make("tbody", {}, snhc.make("tr", {}, ...rows.map(([name]) => snhc.make("th", { scope: "col" }, name))),
      snhc.make("tr", {}, ...rows.map(([, value]) => snhc.make("td", {}, String(value)))))),
    snhc.make("p", {}, (flags & 1 ? "P model, adapts" : "I model, used once") + (flags & 2 ? "; the frequencies were halved before the update (FBA-24)." : "."))];
  }

  _plane(part) {
    const stream = this.stream;
    const [start, end] = stream.span(part);
    const out = [snhc.make("h3", {}, `plane[${stream.parts.plane[part]}]`), snhc.make("div", { class: "big" }, snhc.count(end - start, "bit"), snhc.make("small", {}, `  ${snhc.planeWords(stream, part)}`))];
    const frame = stream.parts.frame[part];
    const pairs = [["bits", `[${start}, ${end})`], ["frames", stream.parts.frames[part] ? `${frame}${stream.parts.frames[part] > 1 ? `..${frame + stream.parts.frames[part] - 1}` : ""}` : "none"]];
    if (stream.face && stream.parts.frames[part] && stream.kindOfPart(part) === "fba_object") {
      const { visemes, expressions } = stream.face;
      if (visemes && visemes[frame * 4] >= 0) pairs.push(["viseme", `${visemes[frame * 4]} and ${visemes[frame * 4 + 1]}, blend ${visemes[frame * 4 + 2]}`]);
      if (expressions && expressions[frame * 6] >= 0) pairs.push(["expression", `${expressions[frame * 6]} at ${expressions[frame * 6 + 1]}, ${expressions[frame * 6 + 2]} at ${expressions[frame * 6 + 3]}`]);
    }
    out.push(this._list(pairs));
    for (const finding of stream.findingsOf.get(part) || []) out.push(this._alarm(`${finding.severity} ${finding.id}: ${finding.message} (${finding.rule})`, "mild"));
    return out;
  }

  _group(node, bits) {
    return [snhc.make("h3", {}, node.label), snhc.make("div", { class: "big" }, bits ? snhc.count(bits[1] - bits[0], "bit") : ""),
      this._list([["bits", bits ? `[${bits[0]}, ${bits[1]})` : null], ["elements", String(node.children.filter((child) => child.kind === "row").length || "")]])];
  }

  _special(node) {
    const out = [snhc.make("h3", {}, node.kind === "finding" ? node.finding.id : node.kind === "error" ? this.stream.data.error.class : "unclaimed"),
      this._alarm(node.label, node.kind === "finding" ? "mild" : "")];
    if (node.bits) out.push(this._list([["bits", `[${node.bits[0]}, ${node.bits[1]})`]]));
    if (node.kind === "error") {
      const { element, value, allowed, path } = this.stream.data.error;
      out.push(this._list([["element", element], ["read", value === null ? null : String(value)], ["allowed", allowed], ["path", path || null]]), ...this.rule(this.stream.data.error.rule));
    } else if (node.kind === "finding") out.push(...this.rule(node.finding.rule));
    return out;
  }

  _unclaimed(bits) {
    return [snhc.make("h3", {}, "unclaimed"), this._list([["bits", `[${bits[0]}, ${bits[1]})`]]), snhc.make("p", {}, "The fault ends the reading; nothing says what these bits are.")];
  }

  rule(id) {
    const rule = this.stream.data.rules[id];
    if (!rule) return [];
    const out = [snhc.make("div", { class: "rule" }, snhc.make("h4", {}, `${id} ${rule.title}`, snhc.make("span", { class: "pill", title: "how sure the register is" }, rule.confidence)),
      snhc.make("p", {}, rule.statement), rule.note ? snhc.make("p", {}, rule.note) : null,
      rule.clause ? snhc.make("p", { class: "mono" }, `clause (unverified): ${rule.clause}`) : null)];
    for (const name of rule.ambiguities) {
      const doubt = this.stream.data.ambiguities[name];
      if (!doubt) continue;
      const followed = this.stream.data.readings[name] || doubt.followed;
      out.push(snhc.make("div", { class: "doubt" }, snhc.make("h4", {}, name), snhc.make("p", {}, doubt.question),
        snhc.make("ul", {}, ...Object.entries(doubt.readings).map(([key, text]) => snhc.make("li", { class: key === followed ? "followed" : "" }, `${key}: ${text}${key === followed ? " (followed)" : ""}`)))));
    }
    return out;
  }
};
