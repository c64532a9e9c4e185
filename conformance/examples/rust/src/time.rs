//! Exact times (FBA-37, FBA-38): fractions without a limit of size.

use std::fmt;

/// A number of any size, 32 bits a digit, the lowest first.
#[derive(Clone)]
struct Big(Vec<u32>);

impl Big {
    fn add_scaled(&mut self, other: &Big, factor: u64) {
        let mut carry: u128 = 0;
        let mut i = 0;
        while i < other.0.len() || carry > 0 {
            if i == self.0.len() {
                self.0.push(0);
            }
            let digit = other.0.get(i).copied().unwrap_or(0);
            carry += u128::from(self.0[i]) + u128::from(digit) * u128::from(factor);
            self.0[i] = carry as u32;
            carry >>= 32;
            i += 1;
        }
    }

    fn times(&self, factor: u64) -> Big {
        let mut product = Big(vec![0]);
        product.add_scaled(self, factor);
        product
    }

    /// Divides in place, returns the remainder; the divisor has at most 32 bits.
    fn divide(&mut self, divisor: u64) -> u64 {
        let mut rest = 0;
        for digit in self.0.iter_mut().rev() {
            let part = rest << 32 | u64::from(*digit);
            *digit = (part / divisor) as u32;
            rest = part % divisor;
        }
        while self.0.len() > 1 && self.0.last() == Some(&0) {
            self.0.pop();
        }
        rest
    }

    fn modulo(&self, divisor: u64) -> u64 {
        self.0.iter().rev().fold(0, |rest, &digit| (rest << 32 | u64::from(digit)) % divisor)
    }
}

impl fmt::Display for Big {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = self.clone();
        let mut parts = Vec::new();
        loop {
            parts.push(rest.divide(1_000_000_000));
            if rest.0 == [0] {
                break;
            }
        }
        write!(out, "{}", parts[parts.len() - 1])?;
        parts.iter().rev().skip(1).try_for_each(|part| write!(out, "{part:09}"))
    }
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 {
        a
    } else {
        gcd(b, a % b)
    }
}

#[derive(Clone)]
pub struct Time {
    over: Big,
    under: Big,
}

impl Time {
    pub fn seconds(seconds: u32) -> Self {
        Time { over: Big(vec![seconds]), under: Big(vec![1]) }
    }

    /// Adds over / under seconds.
    pub fn advance(&mut self, over: u64, under: u64) {
        let shared = gcd(over, under);
        let (over, under) = (over / shared, under / shared);
        let mut sum = self.over.times(under);
        sum.add_scaled(&self.under, over);
        self.over = sum;
        self.under = self.under.times(under);
        // Both fractions were in lowest terms, so a common factor has only primes of the second denominator.
        loop {
            let factor = gcd(gcd(under, self.over.modulo(under)), self.under.modulo(under));
            if factor == 1 {
                return;
            }
            self.over.divide(factor);
            self.under.divide(factor);
        }
    }
}

impl fmt::Display for Time {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.over, self.under)
    }
}
