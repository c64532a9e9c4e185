// FAPs and BAPs: masks, limits, values (FBA-9..20, FBA-28..34, FBA-40).

import { FreshModel, Model, decodeSegment } from './arithmetic.mjs';
import { Fault } from './bits.mjs';
import { BAP_GROUPS, BAP_ROWS, BAP_SCALE, FAP_GROUPS, FAP_ROWS } from './tables.mjs';

const LISTS = [['iMax', 60], ['iMin', -60], ['pMax', 60], ['pMin', -60]]; // FBA-16
const FLAGS = ['is_i_new_max', 'is_i_new_min', 'is_p_new_max', 'is_p_new_min'];

const symmetric = (intra, inter) => ({ iMax: intra, iMin: -intra, pMax: inter, pMin: -inter });
const highLevel = (most) => ({ iMax: most, iMin: 0, pMax: most, pMin: -most }); // FBA-29
const outward = (limit) => Math.ceil(limit / 60) * 60; // FBA-18
const whole = (value) => Math.trunc(value) + 0; // + 0: no negative zero

/** One coded number. */
class Parameter {
  constructor(limits) {
    this.limits = limits; // undivided, undefined where there are none
    this.value = 0;
  }

  /** An intra plane: limits in force and models (FBA-17, FBA-30). */
  begin(limits, step) {
    this.inForce = limits;
    this.step = step;
    this.model = new Model(limits.pMax - limits.pMin + 1);
  }

  beginDivided(divisor, step) {
    const divided = Object.entries(this.limits).map(([list, limit]) => [list, whole(limit / divisor)]);
    this.begin(Object.fromEntries(divided), step);
  }

  /** FBA-31, FBA-32 */
  take(intra, symbol) {
    const level = symbol + (intra ? this.inForce.iMin : this.inForce.pMin);
    const amount = this.step === 0 ? level : level * this.step;
    this.value = (intra ? 0 : this.value) + amount;
    if (!Number.isSafeInteger(this.value)) throw new RangeError('a value needs more than 53 bits');
  }
}

function readValues(bits, intra, parameters) {
  const models = parameters.map(({ inForce, model }) => (intra ? new FreshModel(inForce.iMax - inForce.iMin + 1) : model));
  decodeSegment(bits, models).forEach((symbol, i) => parameters[i].take(intra, symbol));
}

/** Flags and lists of FBA-13, FBA-16; says whether all four lists came. */
function readLimits(bits, groups, isCoded, parameters) {
  const sent = FLAGS.map(() => bits.u(1, 'FBA-13') === 1);
  LISTS.filter((_, i) => sent[i]).forEach(([list, unit]) => {
    groups.forEach((numbers) => numbers.forEach((number, place) => {
      if (place % 4 === 0) bits.marker('FBA-16');
      if (isCoded(number)) {
        const limit = unit * bits.u(5, 'FBA-16') + 0;
        parameters.get(number).limits = { ...parameters.get(number).limits, [list]: limit };
      }
    }));
  });
  return sent.every(Boolean);
}

/** The numbers of a group whose mask bits are 1, the first bit being that of the first number. */
function readGroupMask(bits, numbers, rule) {
  const mask = bits.u(numbers.length, rule).toString(2).padStart(numbers.length, '0');
  return numbers.filter((_, i) => mask[i] === '1');
}

const FACE_GROUPS = FAP_GROUPS.map(([first, last]) => Array.from({ length: last - first + 1 }, (_, i) => first + i));
const EVERY_FAP = FACE_GROUPS.flat();

export class Face {
  constructor() {
    this.seen = false;
    this.viseme = [0, 1, 2].map(() => new Parameter());
    this.expression = [0, 1, 2, 3].map(() => new Parameter());
    this.faps = new Map(FAP_ROWS.map(([, intra, inter], i) => [
      i + 3, new Parameter(symmetric(outward(intra), outward(inter))),
    ]));
    this.coded = new Set();
    this.interpolated = new Set();
    this.decoded = new Set();
    this.states = new Map(EVERY_FAP.map((fap) => [fap, 'U']));
  }

  readHeader(bits) {
    const quant = bits.u(5, 'FBA-9');
    this.coded = new Set();
    this.interpolated = new Set();
    FACE_GROUPS.forEach((numbers) => {
      bits.marker('FBA-10');
      const type = bits.u(2, 'FBA-10');
      const coded = type === 3 ? numbers : type === 0 ? [] : readGroupMask(bits, numbers, 'FBA-10');
      coded.forEach((fap) => this.coded.add(fap));
      if (type === 2) numbers.filter((fap) => !coded.includes(fap)).forEach((fap) => this.interpolated.add(fap));
    });
    bits.u(1, 'FBA-11');
    if (bits.u(1, 'FBA-12') === 1) bits.refuse('Unsupported', 'FBA-12', 1);
    readLimits(bits, FACE_GROUPS.slice(1), (fap) => this.coded.has(fap), this.faps);
    this.faps.forEach((parameter, fap) => {
      if (this.coded.has(fap)) parameter.beginDivided(quant || 1, FAP_ROWS[fap - 3][0] * quant);
    });
    const most = quant === 0 ? 63 : Math.floor((63 + Math.floor(quant / 2)) / quant);
    const scaled = [highLevel(most), quant];
    const viseme = [highLevel(14), 1];
    const expression = [highLevel(6), 1];
    [viseme, viseme, scaled].forEach((form, i) => this.viseme[i].begin(...form));
    [expression, scaled, expression, scaled].forEach((form, i) => this.expression[i].begin(...form));
    this.seen = true;
  }

  /** The FAP data of a plane (FBA-28). */
  read(bits, intra) {
    if (intra) this.readHeader(bits);
    const highLevelSegment = (parameters, selects, most) => {
      const start = bits.position;
      readValues(bits, intra, parameters);
      if (selects.some((i) => parameters[i].value < 0 || parameters[i].value > most)) {
        throw new Fault('RangeViolation', 'FBA-32', start, bits.position);
      }
    };
    if (this.coded.has(1)) {
      highLevelSegment(this.viseme, [0, 1], 14);
      this.visemeDef = bits.u(1, 'FBA-28');
    }
    if (this.coded.has(2)) {
      highLevelSegment(this.expression, [0, 2], 6);
      this.initFace = bits.u(1, 'FBA-28');
      this.expressionDef = bits.u(1, 'FBA-28');
    }
    readValues(bits, intra, [...this.faps].filter(([fap]) => this.coded.has(fap)).map(([, parameter]) => parameter));
    this.coded.forEach((fap) => this.decoded.add(fap));
    EVERY_FAP.forEach((fap) => this.states.set(fap, this.stateNow(fap)));
  }

  /** FBA-34 */
  stateNow(fap) {
    if (this.coded.has(fap)) return 'T';
    if (this.interpolated.has(fap)) return 'I';
    return this.decoded.has(fap) ? 'R' : 'U';
  }

  /** A plane without FAP data. */
  pass() {
    this.states.forEach((state, fap) => { if (state === 'T') this.states.set(fap, 'R'); });
  }

  has(fap) {
    return 'TR'.includes(this.states.get(fap));
  }

  /** The face's keys of CNF-1. */
  get fields() {
    const [select1, select2, blend] = this.viseme.map(({ value }) => value);
    const [first, intensity1, second, intensity2] = this.expression.map(({ value }) => value);
    return {
      faps: EVERY_FAP.map((fap) => (fap > 2 && this.has(fap) ? this.faps.get(fap).value : null)),
      viseme: this.has(1) ? { select1, select2, blend, def: this.visemeDef } : null,
      expression: this.has(2) ? {
        select1: first, intensity1, select2: second, intensity2, init_face: this.initFace, def: this.expressionDef,
      } : null,
      state: EVERY_FAP.map((fap) => this.states.get(fap)).join(''),
    };
  }
}

/** FBA-40 */
export class Body {
  constructor() {
    this.seen = false;
    this.coded = [];
    this.baps = new Map(BAP_GROUPS.flat().map((bap) => {
      const [, iMax, iMin, pMax, pMin] = BAP_ROWS[bap - 1] ?? [];
      return [bap, new Parameter(bap <= BAP_ROWS.length ? { iMax, iMin, pMax, pMin } : {})];
    }));
  }

  readHeader(bits) {
    const scale = BAP_SCALE[bits.u(5, 'FBA-40')];
    this.coded = BAP_GROUPS.flatMap((numbers) => {
      bits.marker('FBA-40');
      const type = bits.u(2, 'FBA-40');
      if (type === 2) bits.refuse('ForbiddenValue', 'FBA-40', 2);
      if (type === 1) return readGroupMask(bits, numbers, 'FBA-40');
      return type === 3 ? numbers : [];
    });
    bits.u(1, 'FBA-40');
    if (bits.u(1, 'FBA-40') === 1) bits.refuse('Unsupported', 'FBA-40', 1);
    const start = bits.position;
    const coded = new Set(this.coded);
    const complete = readLimits(bits, BAP_GROUPS, (bap) => coded.has(bap), this.baps);
    if (!complete && this.coded.some((bap) => bap > BAP_ROWS.length)) {
      throw new Fault('Unsupported', 'FBA-40', start, bits.position);
    }
    this.coded.forEach((bap) => {
      const base = bap > BAP_ROWS.length ? 1 : BAP_ROWS[bap - 1][0];
      this.baps.get(bap).beginDivided(scale || 1, base * scale);
    });
    this.seen = true;
  }

  read(bits, intra) {
    if (intra) this.readHeader(bits);
    readValues(bits, intra, this.coded.map((bap) => this.baps.get(bap)));
  }

  get fields() {
    return { baps: Object.fromEntries(this.coded.map((bap) => [bap, this.baps.get(bap).value])) };
  }
}
