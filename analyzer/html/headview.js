"use strict";

// The shipped head in WebGL, posed by the selected plane; what the selected FAPs move glows.

const VERTEX = `
attribute vec3 place; attribute vec3 normal; attribute vec3 colour; attribute float glow;
uniform mat4 camera; uniform mat3 turn; varying vec3 n; varying vec3 c; varying float g;
void main() { n = turn * normal; c = colour; g = glow; gl_Position = camera * vec4(place, 1.0); }`;
const FRAGMENT = `
precision mediump float; varying vec3 n; varying vec3 c; varying float g; uniform vec3 accent;
void main() {
  vec3 u = normalize(n);
  float key = max(dot(u, normalize(vec3(0.35, 0.5, 0.8))), 0.0);
  float fill = max(dot(u, normalize(vec3(-0.7, 0.1, 0.5))), 0.0);
  vec3 lit = pow(c, vec3(2.2)) * (0.20 + 0.85 * key + 0.22 * fill) + vec3(0.10) * pow(1.0 - abs(u.z), 3.0);
  vec3 shade = pow(lit, vec3(1.0 / 2.2));
  gl_FragColor = vec4(mix(shade, accent * (0.55 + 0.45 * key), 0.72 * g), 1.0);
}`;

snhc.HeadView = class {
  constructor(stream, canvas, words) {
    this.stream = stream;
    this.canvas = canvas;
    this.words = words;
    this.head = new snhc.Head(stream.data.head);
    this.yaw = 0.38;
    this.pitch = 0.06;
    this.zoom = 1;
    this.frame = 0;
    this.faps = [];
    this._buffers();
    this._listen();
    new ResizeObserver(() => this.paint()).observe(canvas);
  }

  // Triangles get vertices of their own: colours change from face to face.
  _buffers() {
    const { triangles, colours } = this.head;
    const gl = this.canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
    this.gl = gl;
    if (!gl) {
      this.words.textContent = "This browser has no WebGL: the head cannot be drawn.";
      return;
    }
    const compile = (kind, source) => {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      return shader;
    };
    const program = gl.createProgram();
    gl.attachShader(program, compile(gl.VERTEX_SHADER, VERTEX));
    gl.attachShader(program, compile(gl.FRAGMENT_SHADER, FRAGMENT));
    gl.linkProgram(program);
    gl.useProgram(program);
    this.uniform = Object.fromEntries(["camera", "turn", "accent"].map((name) => [name, gl.getUniformLocation(program, name)]));
    this.attribute = {};
    for (const [name, size] of [["place", 3], ["normal", 3], ["colour", 3], ["glow", 1]]) {
      const buffer = gl.createBuffer();
      const where = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(where);
      gl.vertexAttribPointer(where, size, gl.FLOAT, false, 0, 0);
      this.attribute[name] = buffer;
    }
    const paint = new Float32Array(triangles.length * 3);
    for (let i = 0; i < triangles.length; i++) {
      for (let axis = 0; axis < 3; axis++) paint[3 * i + axis] = colours[3 * Math.floor(i / 3) + axis] / 255;
    }
    this._upload("colour", paint);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
  }

  _upload(name, numbers) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.attribute[name]);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, numbers, this.gl.DYNAMIC_DRAW);
  }

  _listen() {
    const { canvas } = this;
    let from = null;
    canvas.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!from) return;
      this.turn((event.clientX - from[0]) * 0.009, (event.clientY - from[1]) * 0.009);
      from = [event.clientX, event.clientY];
    });
    canvas.addEventListener("pointerup", () => { from = null; });
    canvas.addEventListener("wheel", (event) => {
      this.zoom = Math.min(4, Math.max(0.5, this.zoom * Math.exp(-event.deltaY * 0.0012)));
      this.paint();
      event.preventDefault();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-0.15, 0], ArrowRight: [0.15, 0], ArrowUp: [0, -0.15], ArrowDown: [0, 0.15] }[event.key];
      if (by) this.turn(...by);
      else if (event.key === "+" || event.key === "-") {
        this.zoom = Math.min(4, Math.max(0.5, this.zoom * (event.key === "+" ? 1.15 : 1 / 1.15)));
        this.paint();
      } else return;
      event.preventDefault();
    });
  }

  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.max(-1.4, Math.min(1.4, this.pitch + pitch));
    this.paint();
  }

  value(fap) {
    const { face } = this.stream;
    const column = (face.pose || face.faps).get(fap);
    const value = column ? column[this.frame] : 0;
    return value === snhc.UNSET || value === undefined ? 0 : value;
  }

  // `faps`: what is selected; visemes and expressions move many.
  show(frame, faps) {
    this.frame = frame;
    this.faps = faps;
    const low = faps.filter((fap) => fap > 2);
    const value = (fap) => this.value(fap);
    this.points = this.head.pose(value);
    this.glow = low.length ? this.head.reach(value, low) : new Float32Array(this.head.count);
    // A 20th of a millimetre is a movement; less is rounding.
    this.movedVertices = this.glow.reduce((count, by) => count + (by > 0.05 ? 1 : 0), 0);
    const names = low.slice(0, 3).map((fap) => `${fap} ${this.stream.data.faps[fap].name}${low.length === 1 ? ` = ${value(fap)}` : ""}`).join(", ");
    const most = this.glow.reduce((a, b) => Math.max(a, b), 0);
    this.words.textContent = low.length
      ? `FAP ${names}${low.length > 3 ? ` and ${low.length - 3} more` : ""} ${low.some((fap) => value(fap)) ? "moves" : "would move"} ${snhc.count(this.movedVertices, "vertex", "vertices")}, up to ${most.toFixed(1)} mm`
      : "The head as this plane poses it. Select a FAP's symbol to see what it moves.";
    this.canvas.setAttribute("aria-label", `the shipped head, frame ${frame}. ${this.words.textContent}`);
    this._geometry(most);
    this.paint();
  }

  _geometry(most) {
    if (!this.gl) return;
    const { triangles } = this.head;
    const { points, glow } = this;
    const normals = new Float32Array(points.length);
    for (let t = 0; t < triangles.length; t += 3) {
      const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
      const [ux, uy, uz] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
      const [vx, vy, vz] = [points[c] - points[a], points[c + 1] - points[a + 1], points[c + 2] - points[a + 2]];
      const n = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (const corner of [a, b, c]) for (let axis = 0; axis < 3; axis++) normals[corner + axis] += n[axis];
    }
    const place = new Float32Array(triangles.length * 3);
    const normal = new Float32Array(triangles.length * 3);
    const shine = new Float32Array(triangles.length);
    for (let i = 0; i < triangles.length; i++) {
      const v = triangles[i];
      place.set(points.subarray(3 * v, 3 * v + 3), 3 * i);
      normal.set(normals.subarray(3 * v, 3 * v + 3), 3 * i);
      shine[i] = most > 0 ? Math.min(1, Math.sqrt(glow[v] / most)) * (glow[v] > 0.05 ? 1 : 0) : 0;
    }
    this._upload("place", place);
    this._upload("normal", normal);
    this._upload("glow", shine);
  }

  paint() {
    const { gl, canvas } = this;
    if (!gl || !this.points || !canvas.clientWidth) return;
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const yaw = snhc.rotation([0, 1, 0], this.yaw);
    const pitch = snhc.rotation([1, 0, 0], this.pitch);
    const turn = [0, 1, 2].flatMap((r) => [0, 1, 2].map((c) => pitch[3 * r] * yaw[c] + pitch[3 * r + 1] * yaw[3 + c] + pitch[3 * r + 2] * yaw[6 + c]));
    // About the middle of the head, in millimetres (7.1 is the origin), seen from afar.
    const [height, distance, far] = [300 / this.zoom, 900, 1600];
    const aspect = canvas.width / canvas.height;
    const tall = height * Math.max(1, 0.78 / aspect);
    const f = (2 * distance) / tall;
    const centre = this.centre();
    const moved = [0, 1, 2].map((r) => -(turn[3 * r] * centre[0] + turn[3 * r + 1] * centre[1] + turn[3 * r + 2] * centre[2]));
    moved[2] -= distance;
    const near = 300;
    const [a, b] = [(far + near) / (near - far), (2 * far * near) / (near - far)];
    const rows = [
      [...turn.slice(0, 3).map((n) => (n * f) / aspect), (moved[0] * f) / aspect], [...turn.slice(3, 6).map((n) => n * f), moved[1] * f],
      [...turn.slice(6, 9).map((n) => n * a), moved[2] * a + b], [...turn.slice(6, 9).map((n) => -n), -moved[2]],
    ];
    const byColumn = (matrix, size) => Float32Array.from({ length: size * size }, (_, i) => matrix[i % size][Math.floor(i / size)]);
    gl.uniformMatrix4fv(this.uniform.camera, false, byColumn(rows, 4));
    gl.uniformMatrix3fv(this.uniform.turn, false, byColumn([turn.slice(0, 3), turn.slice(3, 6), turn.slice(6, 9)], 3));
    gl.uniform3fv(this.uniform.accent, snhc.isDark() ? [1.0, 0.55, 0.25] : [0.93, 0.36, 0.05]);
    gl.drawArrays(gl.TRIANGLES, 0, this.head.triangles.length);
  }

  centre() {
    if (!this._centre) {
      const still = this.head.pose(() => 0);
      const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
      still.forEach((value, i) => {
        low[i % 3] = Math.min(low[i % 3], value);
        high[i % 3] = Math.max(high[i % 3], value);
      });
      this._centre = low.map((value, axis) => (value + high[axis]) / 2);
    }
    return this._centre;
  }
};
