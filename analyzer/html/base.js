"use strict";

// Everything the page defines. No script knows the others but through it.
const snhc = {};

// Elements are made here only, and what comes from the stream goes in as text: no user data is ever markup.
snhc.make = (tag, attributes, ...children) => {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes || {})) {
    if (name === "class") element.className = value;
    else if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined && child !== ""));
  return element;
};

snhc.byId = (id) => document.getElementById(id);
snhc.count = (n, one, many) => `${n.toLocaleString("en")} ${n === 1 ? one : many || one + "s"}`;

// -- columns (packing.py) --

const SIZES = { B: Uint8Array, h: Int16Array, H: Uint16Array, i: Int32Array, I: Uint32Array, f: Float32Array, d: Float64Array };

snhc.decodeBase64 = (text) => {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
};

snhc.unpack = (text) => new SIZES[text[0]](snhc.decodeBase64(text.slice(2)).buffer);

// The last index with column[index] <= value; the column rises.
snhc.lastAtMost = (column, value, length = column.length) => {
  let low = 0;
  let high = length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (column[middle] <= value) low = middle + 1;
    else high = middle;
  }
  return low - 1;
};

// -- looks --

// A canvas needs what `light-dark()` stands for, which only a property that takes a colour tells.
const colours = new Map();
snhc.colour = (name) => {
  const root = document.documentElement;
  const key = `${root.dataset.theme} ${name}`;
  if (!colours.has(key)) {
    root.style.caretColor = `var(--${name})`;
    colours.set(key, getComputedStyle(root).caretColor);
    root.style.caretColor = "";
  }
  return colours.get(key);
};
snhc.isDark = () => document.documentElement.dataset.theme === "dark";

// A canvas drawn at the screen's own resolution; `draw(context, width, height)`.
snhc.draw = (canvas, draw) => {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  if (!width || !height) return;
  const scale = window.devicePixelRatio || 1;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, width, height);
  draw(context, width, height);
};
