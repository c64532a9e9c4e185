//! The arithmetic decoder, FBA-21..27.
//!
//! Instead of code_value the distance code_value - low is kept: what renormalisation subtracts, it subtracts from both.
//! P models are Fenwick trees, so that a symbol of 3,721 costs a dozen steps.

use crate::bits::{fault, Bits, Fault};

const QUARTER: u32 = 16384;
const HALF: u32 = 32768;
const GUARD_AFTER: u32 = 22;
const LOOK_AHEAD: usize = 14;
const MAX_FREQUENCY: u32 = 16383;

/// An adaptive model (FBA-22, FBA-24).
#[derive(Default)]
pub struct Model {
    frequency: Vec<u32>,
    /// tree[i]: sum of the frequencies of the i & -i symbols that end with symbol i - 1.
    tree: Vec<u32>,
    total: u32,
}

impl Model {
    pub fn reset(&mut self, symbols: usize) {
        self.frequency.clear();
        self.frequency.resize(symbols, 1);
        self.rebuild();
    }

    fn rebuild(&mut self) {
        let count = self.frequency.len();
        self.tree.clear();
        self.tree.push(0);
        self.tree.extend_from_slice(&self.frequency);
        for i in 1..=count {
            let parent = i + (i & i.wrapping_neg());
            if parent <= count {
                self.tree[parent] += self.tree[i];
            }
        }
        self.total = self.frequency.iter().sum();
    }

    /// The first symbol with which the running sum of frequencies reaches `wanted`, and the sum before it.
    fn find(&self, wanted: u32) -> (usize, u32) {
        let count = self.frequency.len();
        let mut at = 0;
        let mut before = 0;
        let mut step = count.next_power_of_two();
        while step > 0 {
            if at + step <= count && before + self.tree[at + step] < wanted {
                at += step;
                before += self.tree[at];
            }
            step /= 2;
        }
        (at, before)
    }

    fn count(&mut self, symbol: usize) {
        if self.total == MAX_FREQUENCY {
            for frequency in &mut self.frequency {
                *frequency = (*frequency + 1) / 2;
            }
            self.rebuild();
        }
        self.frequency[symbol] += 1;
        self.total += 1;
        let mut i = symbol + 1;
        while i < self.tree.len() {
            self.tree[i] += 1;
            i += i & i.wrapping_neg();
        }
    }
}

pub struct Segment<'a, 'd> {
    bits: &'a Bits<'d>,
    pos: usize,
    zeros: u32,
    false_guard: Option<usize>,
    /// Positions behind each data bit.
    behind: Vec<usize>,
    low: u32,
    length: u32,
    above_low: u32,
}

impl<'a, 'd> Segment<'a, 'd> {
    /// A segment that starts at the reader's position.
    pub fn open(bits: &'a Bits<'d>) -> Self {
        let mut segment = Segment {
            bits,
            pos: bits.pos,
            zeros: 0,
            false_guard: None,
            behind: Vec::new(),
            low: 0,
            length: 65536,
            above_low: 0,
        };
        for _ in 0..16 {
            segment.shift_in();
        }
        segment
    }

    fn shift_in(&mut self) {
        if self.zeros == GUARD_AFTER {
            if !self.bits.bit(self.pos) && self.false_guard.is_none() {
                self.false_guard = Some(self.pos);
            }
            self.pos += 1;
            self.zeros = 0;
        }
        let bit = self.bits.bit(self.pos);
        self.pos += 1;
        self.zeros = if bit { 0 } else { self.zeros + 1 };
        self.behind.push(self.pos);
        self.above_low = self.above_low * 2 + u32::from(bit);
    }

    fn target(&self, total: u32) -> u32 {
        ((self.above_low + 1) * total - 1) / self.length
    }

    /// FBA-23 behind the choice of the symbol: its share of cum[] runs from `lower` to `upper`.
    fn narrow(&mut self, lower: u32, upper: u32, total: u32) {
        let cut = self.length * lower / total;
        self.length = self.length * upper / total - cut;
        self.low += cut;
        self.above_low -= cut;
        loop {
            let high = self.low + self.length - 1;
            let dropped = if high < HALF {
                0
            } else if self.low >= HALF {
                HALF
            } else if self.low >= QUARTER && high < HALF + QUARTER {
                QUARTER
            } else {
                break;
            };
            self.low = (self.low - dropped) * 2;
            self.length *= 2;
            self.shift_in();
        }
    }

    /// A symbol of a model that was just reset (I models).
    pub fn fresh(&mut self, symbols: u32) -> u32 {
        let rank = self.target(symbols);
        self.narrow(rank, rank + 1, symbols);
        symbols - 1 - rank
    }

    /// A symbol of a P model, which learns it.
    pub fn adaptive(&mut self, model: &mut Model) -> u32 {
        let total = model.total;
        let (symbol, before) = model.find(total - self.target(total));
        let upper = total - before;
        self.narrow(upper - model.frequency[symbol], upper, total);
        model.count(symbol);
        symbol as u32
    }

    /// FBA-26, FBA-27: the position at which raw bits go on.
    pub fn close(self) -> Result<usize, Fault> {
        let end = self.behind[self.behind.len() - 1 - LOOK_AHEAD];
        if end > self.bits.end {
            return fault("Truncated", "FBA-27", self.bits.pos..self.bits.end);
        }
        match self.false_guard {
            Some(at) if at < end => fault("MarkerBit", "FBA-25", at..at + 1),
            _ => Ok(end),
        }
    }
}
