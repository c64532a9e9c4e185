"use strict";

// The mesh of the selected plane: triangles, nodes, their order, and where they moved from.

snhc.MeshView = class {
  constructor(stream, canvas, words, select) {
    this.stream = stream;
    this.canvas = canvas;
    this.words = words;
    this.select = select;
    this.frame = 0;
    this.part = -1;
    this.node = -1;
    this.places = [];
    const { nodes } = stream.mesh;
    // One frame for all planes, so that motion is seen as motion.
    this.box = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < nodes.length; i += 2) {
      this.box[0] = Math.min(this.box[0], nodes[i]);
      this.box[1] = Math.min(this.box[1], nodes[i + 1]);
      this.box[2] = Math.max(this.box[2], nodes[i]);
      this.box[3] = Math.max(this.box[3], nodes[i + 1]);
    }
    canvas.addEventListener("click", (event) => {
      const box = canvas.getBoundingClientRect();
      this._pick(event.clientX - box.left, event.clientY - box.top);
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (step === undefined || !this.count) return;
      this._choose((this.node + step + this.count) % this.count);
      event.preventDefault();
    });
    new ResizeObserver(() => this.paint()).observe(canvas);
  }

  get count() { return this.stream.mesh.first[this.frame + 1] - this.stream.mesh.first[this.frame]; }

  at(frame, node) {
    const i = 2 * (this.stream.mesh.first[frame] + node);
    return [this.stream.mesh.nodes[i], this.stream.mesh.nodes[i + 1]];
  }

  // The element of a node in the selected plane: its first bit is the way to it.
  _choose(node) {
    const { stream } = this;
    const part = this.part;
    for (let row = stream.parts.row[part]; part >= 0 && row < stream.partEnd(part); row++) {
      if (stream.nodeOf(row) === node) {
        this.select({ part, row, symbol: -1, bits: [stream.start[row], stream.end(row)] }, null);
        return;
      }
    }
    this.node = node;
    this.paint();
  }

  _pick(x, y) {
    let best = -1;
    let near = 18 * 18;
    this.places.forEach(([px, py], node) => {
      const distance = (px - x) ** 2 + (py - y) ** 2;
      if (distance < near) [near, best] = [distance, node];
    });
    if (best >= 0) this._choose(best);
  }

  show(part, frame, node) {
    this.part = part;
    this.frame = frame;
    this.node = node;
    this.paint();
  }

  paint() {
    const { mesh } = this.stream;
    const { frame, node } = this;
    const geometry = mesh.geometry[frame];
    const triangles = geometry >= 0 ? mesh.meshes[geometry].triangles : [];
    const order = geometry >= 0 ? mesh.meshes[geometry].order : [];
    const count = this.count;
    const moved = frame > 0 && mesh.geometry[frame - 1] === geometry && mesh.first[frame] - mesh.first[frame - 1] === count;
    const rank = new Map(Array.from(order, (one, i) => [one, i]));
    const half = ([x, y]) => `(${x / 2}, ${y / 2})`;
    let text = `${snhc.count(count, "node")}, ${snhc.count(triangles.length / 3, "triangle")}`;
    if (node >= 0 && node < count) {
      text += ` · node ${node} at ${half(this.at(frame, node))} pixels, number ${rank.get(node) ?? "?"} in the order`;
      if (moved) {
        const [a, b] = [this.at(frame - 1, node), this.at(frame, node)];
        text += `, moved by ${half([b[0] - a[0], b[1] - a[1]])}`;
      }
    }
    this.words.textContent = text;
    this.canvas.setAttribute("aria-label", `mesh: ${text}`);
    snhc.draw(this.canvas, (context, width, height) => {
      const [x0, y0, x1, y1] = this.box;
      const scale = Math.min((width - 40) / Math.max(1, x1 - x0), (height - 40) / Math.max(1, y1 - y0));
      const place = ([x, y]) => [width / 2 + (x - (x0 + x1) / 2) * scale, height / 2 + (y - (y0 + y1) / 2) * scale];
      this.places = Array.from({ length: count }, (_, i) => place(this.at(frame, i)));
      context.lineJoin = "round";
      for (let t = 0; t < triangles.length; t += 3) {
        const corners = [triangles[t], triangles[t + 1], triangles[t + 2]];
        context.beginPath();
        corners.forEach((corner, i) => (i ? context.lineTo(...this.places[corner]) : context.moveTo(...this.places[corner])));
        context.closePath();
        context.fillStyle = snhc.colour(corners.includes(node) ? "select" : "shade");
        context.fill();
        context.strokeStyle = snhc.colour("soft");
        context.globalAlpha = 0.55;
        context.lineWidth = 1;
        context.stroke();
        context.globalAlpha = 1;
      }
      if (moved) this._vectors(context, Array.from({ length: count }, (_, i) => place(this.at(frame - 1, i))), width, height);
      // Numbers only where they do not lie on each other.
      const roomy = count <= 150;
      context.font = "10.5px system-ui, sans-serif";
      context.textAlign = "center";
      this.places.forEach(([x, y], i) => {
        context.beginPath();
        context.arc(x, y, i === node ? 6 : roomy ? 3.2 : 1.8, 0, 2 * Math.PI);
        context.fillStyle = snhc.colour(i === node ? "accent" : "k-data");
        context.fill();
        if (roomy || i === node) {
          context.fillStyle = snhc.colour(i === node ? "accent" : "soft");
          context.fillText(rank.has(i) ? String(rank.get(i)) : String(i), x, y - 8);
        }
      });
    });
  }

  // Where the nodes come from; small movements are drawn larger, and it is said.
  _vectors(context, from, width, height) {
    const longest = from.reduce((most, [x, y], i) => Math.max(most, Math.hypot(x - this.places[i][0], y - this.places[i][1])), 0);
    const times = [16, 8, 4, 2].find((factor) => longest > 0 && longest * factor <= 26) || 1;
    context.strokeStyle = context.fillStyle = snhc.colour("bad");
    context.lineWidth = 1.5;
    from.forEach(([x, y], i) => {
      const [px, py] = this.places[i];
      this._arrow(context, [px - (px - x) * times, py - (py - y) * times], [px, py]);
    });
    if (times > 1) {
      context.font = "11px system-ui, sans-serif";
      context.textAlign = "right";
      context.fillText(`vectors × ${times}`, width - 10, height - 8);
    }
  }

  _arrow(context, [x0, y0], [x1, y1]) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    if (length < 1) return;
    const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
    const tip = Math.min(6, length);
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
    context.stroke();
    context.beginPath();
    context.moveTo(x1, y1);
    context.lineTo(x1 - tip * ux + tip * 0.5 * uy, y1 - tip * uy - tip * 0.5 * ux);
    context.lineTo(x1 - tip * ux - tip * 0.5 * uy, y1 - tip * uy + tip * 0.5 * ux);
    context.fill();
  }
};
