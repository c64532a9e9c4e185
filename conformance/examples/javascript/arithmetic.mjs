// The arithmetic decoder, FBA-21..27.

import { Fault } from './bits.mjs';

const Q1 = 16384;
const Q2 = 32768;
const Q3 = 49152;
const MAX_FREQUENCY = 16383;
const GUARD_AFTER = 22;
const BLOCK = 64;

/** A P model: frequencies, and their sums in blocks of 64, which a search crosses in one step. */
export class Model {
  constructor(symbols) {
    this.frequencies = new Uint16Array(symbols).fill(1);
    this.blocks = new Uint32Array(Math.ceil(symbols / BLOCK));
    this.sum();
  }

  sum() {
    this.blocks.fill(0);
    this.total = 0;
    this.frequencies.forEach((frequency, symbol) => {
      this.blocks[Math.floor(symbol / BLOCK)] += frequency;
      this.total += frequency;
    });
  }

  /** The smallest symbol whose successors together have at most `c`; upper and lower are cum[s] and cum[s + 1]. */
  locate(c) {
    let upper = this.total;
    let block = 0;
    while (upper - this.blocks[block] > c) upper -= this.blocks[block++];
    let symbol = block * BLOCK;
    while (upper - this.frequencies[symbol] > c) upper -= this.frequencies[symbol++];
    return { symbol, upper, lower: upper - this.frequencies[symbol] };
  }

  /** FBA-24 */
  learn(symbol) {
    if (this.total === MAX_FREQUENCY) {
      this.frequencies.forEach((frequency, i, all) => { all[i] = (frequency + 1) >> 1; });
      this.sum();
    }
    this.frequencies[symbol] += 1;
    this.blocks[Math.floor(symbol / BLOCK)] += 1;
    this.total += 1;
  }
}

/** An I model, used once: all frequencies are 1. */
export class FreshModel {
  constructor(symbols) {
    this.total = symbols;
  }

  locate(c) {
    return { symbol: this.total - 1 - c, upper: c + 1, lower: c };
  }

  learn() {}
}

/** The data bits from a position on, guards removed (FBA-25), without end: [bit, position behind it, first false guard]. */
function* dataBits(bits, position) {
  let falseGuard = Infinity;
  for (let zeros = 0; ;) {
    if (zeros === GUARD_AFTER) {
      if (bits.at(position) === 0) falseGuard = Math.min(falseGuard, position);
      position += 1;
      zeros = 0;
    }
    const bit = bits.at(position);
    position += 1;
    zeros = bit === 1 ? 0 : zeros + 1;
    yield [bit, position, falseGuard];
  }
}

/** Decodes one segment at the reader's position with the models, in their order; the reader stands behind it. */
export function decodeSegment(bits, models) {
  const start = bits.position;
  const source = dataBits(bits, start);
  const ends = [];
  const falseGuards = [];
  let low = 0;
  let high = 65535;
  let code = 0;
  const shift = () => {
    const [bit, position, falseGuard] = source.next().value;
    ends.push(position);
    falseGuards.push(falseGuard);
    code = 2 * code + bit;
  };
  for (let i = 0; i < 16; i += 1) shift();
  const symbols = models.map((model) => {
    const length = high - low + 1;
    const { total } = model;
    const found = model.locate(Math.floor(((code - low + 1) * total - 1) / length));
    high = low - 1 + Math.floor((length * found.upper) / total);
    low += Math.floor((length * found.lower) / total);
    for (;;) {
      let away;
      if (high < Q2) away = 0;
      else if (low >= Q2) away = Q2;
      else if (low >= Q1 && high < Q3) away = Q1;
      else break;
      low = 2 * (low - away);
      high = 2 * (high - away) + 1;
      code -= away;
      shift();
    }
    model.learn(found.symbol);
    return found.symbol;
  });
  // FBA-26: 16 bits were fetched ahead, the segment owns the first two of the last 16.
  const last = ends.length - 15;
  if (ends[last] > bits.length) throw new Fault('Truncated', 'FBA-27', start, bits.length);
  const guard = falseGuards[last];
  if (guard < ends[last]) throw new Fault('MarkerBit', 'FBA-25', guard, guard + 1);
  bits.position = ends[last];
  return symbols;
}
