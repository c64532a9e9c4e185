// Raw bits, and faults (CNF-7, CNF-21).

/** The first fault of a stream. */
export class Fault extends Error {
  constructor(errorClass, rule, first, end) {
    super(`${errorClass} (${rule}) at [${first}, ${end})`);
    this.report = { class: errorClass, rule, bits: [first, end] };
  }
}

export class Bits {
  constructor(bytes) {
    this.bytes = bytes;
    this.length = bytes.length * 8;
    this.position = 0;
    const last = bytes.findLastIndex((byte) => byte !== 0);
    this.contentEnd = last < 0 ? 0 : last * 8 + 8 - Math.log2(bytes[last] & -bytes[last]);
  }

  /** One bit; behind the end of the data 0 (FBA-27). */
  at(position) {
    const byte = Math.floor(position / 8);
    return byte < this.bytes.length ? (this.bytes[byte] >> (7 - (position % 8))) & 1 : 0;
  }

  /** The `count` bits at a position as a number, undefined if they are not all there. */
  peek(count, position = this.position) {
    if (position + count > this.length) return undefined;
    let value = 0;
    for (let i = 0; i < count; i += 1) value = value * 2 + this.at(position + i);
    return value;
  }

  u(count, rule) {
    const value = this.peek(count);
    if (value === undefined) throw new Fault('Truncated', rule, this.position, this.length);
    this.position += count;
    return value;
  }

  marker(rule) {
    if (this.u(1, rule) === 0) this.refuse('MarkerBit', rule, 1);
  }

  /** Rejects the `count` bits read last. */
  refuse(errorClass, rule, count) {
    throw new Fault(errorClass, rule, this.position - count, this.position);
  }

  /** FBA-3: the position behind the stuffing, undefined if something else stands here. */
  get behindStuffing() {
    const count = 8 - (this.position % 8);
    return this.peek(count) === 2 ** (count - 1) - 1 ? this.position + count : undefined;
  }
}
