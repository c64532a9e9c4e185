"use strict";

// From FAP values to the vertices of the shipped head (FAT-2..5, FAT-9; the hinges of fat_bulk).

snhc.Head = class {
  constructor(data) {
    this.neutral = snhc.unpack(data.vertices);
    this.triangles = snhc.unpack(data.triangles);
    this.colours = snhc.unpack(data.colours);
    this.nodes = data.nodes;
    this.meshes = data.meshes;
    this.under = data.under;
    this.moved = snhc.unpack(data.moved);
    this.by = snhc.unpack(data.by);
    const numbers = snhc.unpack(data.hinges);
    this.hinges = [];
    let first = 0;
    for (let i = 0; i < numbers.length; i += 6) {
      const [fap, start, side, length, sign, count] = numbers.subarray(i, i + 6);
      this.hinges.push({ fap, start, side, length: length || Infinity, sign, first, count });
      first += count;
    }
  }

  get count() { return this.neutral.length / 3; }

  // `value(fap)`: its value, 0 where it has none.
  pose(value) {
    const points = Float64Array.from(this.neutral);
    for (const { fap, start, side, length, sign, first, count } of this.hinges) {
      const at = value(fap);
      const factor = sign * (side ? Math.min(Math.max(side * (at - start), 0), length) : at);
      if (!factor) continue;
      for (let i = first; i < first + count; i++) {
        for (let axis = 0; axis < 3; axis++) points[3 * this.moved[i] + axis] += factor * this.by[3 * i + axis];
      }
    }
    const steps = new Map();
    for (const [name, node] of Object.entries(this.nodes)) steps.set(name, this._step(node, value));
    for (const [mesh, first, count] of this.meshes) {
      for (let name = this.under[mesh]; name; name = this.nodes[name].parent) {
        const { scale, rotations, translation } = steps.get(name);
        for (let v = 3 * first; v < 3 * (first + count); v += 3) {
          let [x, y, z] = [points[v] * scale[0], points[v + 1] * scale[1], points[v + 2] * scale[2]];
          for (const m of rotations) {
            [x, y, z] = [m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z];
          }
          points[v] = x + translation[0];
          points[v + 1] = y + translation[1];
          points[v + 2] = z + translation[2];
        }
      }
    }
    return Float32Array.from(points);
  }

  _step(node, value) {
    const scale = [...node.scale];
    const translation = [...node.translation];
    const rotations = node.rotation[3] ? [snhc.rotation(node.rotation, node.rotation[3])] : [];
    for (const [fap, field, unit, ...definition] of node.moves) {
      const amount = value(fap) * unit;
      if (!amount) continue;
      if (field === "rotation") rotations.push(snhc.rotation(definition, amount * definition[3]));
      else for (let axis = 0; axis < 3; axis++) (field === "translation" ? translation : scale)[axis] += amount * definition[axis];
    }
    return { scale, rotations, translation };
  }

  // How far each vertex is moved by some FAPs, in model units: by their values, or by a small step where they are 0.
  reach(value, faps) {
    const chosen = new Set(faps);
    const steps = new Map(faps.map((fap) => [fap, value(fap) || 100]));
    const base = this.pose((fap) => (chosen.has(fap) ? 0 : value(fap)));
    const with_ = this.pose((fap) => (chosen.has(fap) ? steps.get(fap) : value(fap)));
    const out = new Float32Array(this.count);
    for (let v = 0; v < out.length; v++) {
      out[v] = Math.hypot(with_[3 * v] - base[3 * v], with_[3 * v + 1] - base[3 * v + 1], with_[3 * v + 2] - base[3 * v + 2]);
    }
    return out;
  }
};

// A right-handed rotation about an axis, row by row (FAT-9).
snhc.rotation = ([ax, ay, az], angle) => {
  const length = Math.hypot(ax, ay, az);
  if (!length) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const [x, y, z] = [ax / length, ay / length, az / length];
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const t = 1 - c;
  return [t * x * x + c, t * x * y - s * z, t * x * z + s * y, t * x * y + s * z, t * y * y + c, t * y * z - s * x,
    t * x * z - s * y, t * y * z + s * x, t * z * z + c];
};
