//! Raw bits and faults (CNF-7, CNF-21).

use std::io;
use std::ops::Range;

/// The first fault of a stream: class, rule, bits.
#[derive(Debug)]
pub struct Fault {
    pub class: &'static str,
    pub rule: &'static str,
    pub bits: Range<usize>,
}

pub fn fault<T>(class: &'static str, rule: &'static str, bits: Range<usize>) -> Result<T, Fault> {
    Err(Fault { class, rule, bits })
}

/// Why decoding stopped early.
pub enum Stop {
    Fault(Fault),
    Output(io::Error),
}

impl From<Fault> for Stop {
    fn from(fault: Fault) -> Self {
        Stop::Fault(fault)
    }
}

impl From<io::Error> for Stop {
    fn from(error: io::Error) -> Self {
        Stop::Output(error)
    }
}

pub struct Bits<'a> {
    data: &'a [u8],
    pub pos: usize,
    pub end: usize,
    /// Behind the last bit that is 1.
    pub last_one: usize,
}

impl<'a> Bits<'a> {
    pub fn new(data: &'a [u8]) -> Self {
        let last_one = match data.iter().rposition(|&byte| byte != 0) {
            Some(at) => at * 8 + 8 - data[at].trailing_zeros() as usize,
            None => 0,
        };
        Bits { data, pos: 0, end: data.len() * 8, last_one }
    }

    /// One bit; behind the end of the data everything is 0 (FBA-27).
    pub fn bit(&self, at: usize) -> bool {
        self.data.get(at / 8).is_some_and(|byte| byte & (0x80 >> (at % 8)) != 0)
    }

    /// Up to 32 bits from `at`, if all of them are there.
    pub fn look(&self, at: usize, count: usize) -> Option<u32> {
        if at.checked_add(count)? > self.end {
            return None;
        }
        Some((at..at + count).fold(0, |value, i| value << 1 | u32::from(self.bit(i))))
    }

    pub fn take(&mut self, count: usize, rule: &'static str) -> Result<u32, Fault> {
        match self.look(self.pos, count) {
            Some(value) => {
                self.pos += count;
                Ok(value)
            }
            None => fault("Truncated", rule, self.pos..self.end),
        }
    }

    pub fn flag(&mut self, rule: &'static str) -> Result<bool, Fault> {
        Ok(self.take(1, rule)? == 1)
    }

    pub fn marker(&mut self, rule: &'static str) -> Result<(), Fault> {
        if self.flag(rule)? {
            return Ok(());
        }
        fault("MarkerBit", rule, self.back(1))
    }

    /// The span of the last `count` bits taken.
    pub fn back(&self, count: usize) -> Range<usize> {
        self.pos - count..self.pos
    }

    /// FBA-3: where the stuffing that stands here ends, if it is exactly the stuffing.
    pub fn behind_stuffing(&self) -> Option<usize> {
        let count = 8 - self.pos % 8;
        let exact = (1u32 << (count - 1)) - 1;
        (self.look(self.pos, count)? == exact).then_some(self.pos + count)
    }
}
