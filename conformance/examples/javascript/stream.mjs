// Headers, object, planes, times (SYS-1..7, FBA-1..8, FBA-35, FBA-37..42, FBA-44), and the lines of CNF-1.

import { Bits, Fault } from './bits.mjs';
import { Body, Face } from './parameters.mjs';

const MAX_SKIPPED = 1_000_000;
const MAX_IDLE = 1024;
const CODE = { sequence: 0x1b0, end: 0x1b1, userData: 0x1b2, visualObject: 0x1b5, fba: 0x1ba, plane: 0x1bb, mesh: 0x1bc };
const MESH_PLANE = 0x1bd;
const STILL_TEXTURE = 0x1be;
const NOT_FIRST = [CODE.end, CODE.userData, CODE.visualObject, CODE.plane, MESH_PLANE];

/** A fraction of BigInts in lowest terms. */
class Fraction {
  constructor(over, under = 1n) {
    let [a, b] = [over, under];
    while (b !== 0n) [a, b] = [b, a % b];
    this.over = over / a;
    this.under = under / a;
  }

  plus(other) {
    return new Fraction(this.over * other.under + other.over * this.under, this.under * other.under);
  }

  times(count) {
    return new Fraction(this.over * BigInt(count), this.under);
  }

  toString() {
    return `${this.over}/${this.under}`;
  }
}

class Clock {
  constructor() {
    this.time = new Fraction(0n);
    this.period = new Fraction(1n, 30n);
  }

  /** FBA-6..8, FBA-37, FBA-38: returns the time of this plane, and goes on to the next. */
  readHeader(bits, intra) {
    if (intra && bits.u(1, 'FBA-6') === 1) {
      const sixteenths = 16 * bits.u(8, 'FBA-6') + bits.u(4, 'FBA-6');
      const offset = bits.u(1, 'FBA-6') === 1;
      if (sixteenths === 0) bits.refuse('ForbiddenValue', 'FBA-37', 13);
      this.period = new Fraction(offset ? 16n * 1001n : 16n, BigInt(sixteenths) * (offset ? 1000n : 1n));
    }
    if (intra && bits.u(1, 'FBA-7') === 1) {
      const field = (count, most) => {
        const value = bits.u(count, 'FBA-7');
        if (value > most) bits.refuse('ForbiddenValue', 'FBA-7', count);
        return value;
      };
      const hours = field(5, 23);
      const minutes = field(6, 59);
      bits.marker('FBA-7');
      const seconds = field(6, 59);
      this.time = new Fraction(BigInt(hours * 3600 + minutes * 60 + seconds));
    }
    const skipped = bits.u(1, 'FBA-8') === 1 ? Clock.readSkipped(bits) : 0;
    const now = this.time;
    this.time = now.plus(this.period.times(skipped + 1));
    return now;
  }

  static readSkipped(bits) {
    const start = bits.position;
    for (let sum = 0; ;) {
      const part = bits.u(4, 'FBA-8');
      sum += part;
      if (sum > MAX_SKIPPED) throw new Fault('ResourceLimit', 'FBA-8', start, bits.position);
      if (part !== 15) return sum;
    }
  }
}

/** The next start code behind user data (SYS-5). */
function readCode(bits) {
  for (;;) {
    const start = bits.position;
    const code = bits.u(32, 'SYS-1');
    if (code !== CODE.userData) return code;
    while (bits.peek(24) !== 1) {
      if (bits.peek(24) === undefined) throw new Fault('Truncated', 'SYS-5', start, bits.length);
      bits.position += 8;
    }
  }
}

/** SYS-1..7: everything up to and including the object start code. */
function readHeaders(bits) {
  if (bits.length < 32) throw new Fault('InputFormat', 'FBA-44', 0, bits.length);
  const first = bits.u(32, 'FBA-1');
  if (first === CODE.fba) return;
  if (first === CODE.mesh) bits.refuse('Unsupported', 'SYS-7', 32);
  if (first === STILL_TEXTURE || (first >= 0x100 && first <= 0x12f)) bits.refuse('Unsupported', 'SYS-4', 32);
  if (NOT_FIRST.includes(first)) bits.refuse('InconsistentSemantics', 'SYS-7', 32);
  if (first !== CODE.sequence) bits.refuse('InputFormat', 'FBA-1', 32);
  for (let code; code !== CODE.visualObject;) {
    bits.u(8, 'SYS-2');
    code = readCode(bits);
    if (code === CODE.end && bits.peek(32) === CODE.sequence) bits.position += 32;
    else if (code !== CODE.visualObject) bits.refuse('InconsistentSemantics', 'SYS-2', 32);
  }
  if (bits.u(1, 'SYS-3') === 1) {
    bits.u(4, 'SYS-3');
    if (bits.u(3, 'SYS-3') === 0) bits.refuse('ReservedValue', 'SYS-3', 3);
  }
  const type = bits.u(4, 'SYS-4');
  if (type === 0 || type > 5) bits.refuse('ReservedValue', 'SYS-4', 4);
  if (![3, 4].includes(type)) bits.refuse('Unsupported', 'SYS-4', 4);
  const behind = bits.behindStuffing;
  if (behind === undefined) {
    throw new Fault('ForbiddenValue', 'SYS-3', bits.position, Math.ceil(bits.position / 8) * 8);
  }
  bits.position = behind;
  if (readCode(bits) !== (type === 4 ? CODE.fba : CODE.mesh)) bits.refuse('InconsistentSemantics', 'SYS-6', 32);
  if (type === 3) bits.refuse('Unsupported', 'SYS-4', 32);
}

/** FBA-3, FBA-42, FBA-44: 'end', 'plane', or 'start code' for a plane behind its start code. */
function nextAt(bits, first) {
  if (bits.position >= bits.contentEnd) return 'end';
  const behind = bits.behindStuffing;
  if (behind === bits.length) return 'end';
  if (behind !== undefined && bits.peek(24, behind) === 1) {
    const code = bits.peek(32, behind);
    if (code === undefined) throw new Fault('Truncated', 'FBA-44', behind, bits.length);
    if (code !== CODE.plane) return 'end';
    bits.position = behind + 32;
    return 'start code';
  }
  if (first && bits.peek(32) === CODE.plane) {
    bits.position += 32;
    return 'start code';
  }
  return 'plane';
}

/** Yields the header and one record per plane; throws a Fault. */
export function* decodeStream(bytes) {
  const bits = new Bits(bytes);
  readHeaders(bits);
  yield { format: 'snhc-decoded', version: 1, kind: 'fba' };
  const face = new Face();
  const body = new Body();
  const clock = new Clock();
  let idle = 0;
  for (let index = 0; ; index += 1) {
    const next = nextAt(bits, index === 0);
    if (next === 'end') return;
    const start = bits.position;
    const intra = bits.u(1, 'FBA-5') === 1;
    const mask = bits.u(2, 'FBA-5');
    const parts = [[1, face], [2, body]].filter(([bit]) => (mask & bit) !== 0).map(([, part]) => part);
    if (!intra && parts.some((part) => !part.seen)) {
      throw new Fault('InconsistentSemantics', 'FBA-35', start, start + 1);
    }
    const time = clock.readHeader(bits, intra);
    if (!parts.includes(face)) face.pass();
    parts.forEach((part) => part.read(bits, intra));
    if (parts.length > 0) idle = 0;
    else idle = next === 'start code' ? 1 : idle + 1;
    if (idle > MAX_IDLE) throw new Fault('ResourceLimit', 'FBA-42', start, bits.position);
    yield { index, time: String(time), intra, ...face.fields, ...(parts.includes(body) ? body.fields : {}) };
  }
}
