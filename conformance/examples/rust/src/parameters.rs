//! FAPs and BAPs: masks, limits, values (FBA-9..20, FBA-28..34, FBA-40).

use crate::bits::{fault, Bits, Fault};
use crate::coder::{Model, Segment};
use crate::tables::{BAP_BASE, BAP_GROUPS, BAP_LIMITS, BAP_ORDER, BAP_SCALE, FAP_GROUPS, LOW_LEVEL};

/// The four range lists, in the order of FBA-16.
const UNITS: [i64; 4] = [60, -60, 60, -60];

/// One coded number.
#[derive(Default)]
struct Slot {
    /// FBA-19: as sent, or the defaults.
    sent: [i64; 4],
    /// In force: intra maximum and minimum, inter maximum and minimum.
    limits: [i64; 4],
    step: i64,
    value: i64,
    model: Model,
}

impl Slot {
    fn prepare(&mut self, limits: [i64; 4], step: i64) {
        self.limits = limits;
        self.step = step;
        self.model.reset((limits[2] - limits[3] + 1) as usize);
    }

    fn read(&mut self, segment: &mut Segment, intra: bool) {
        let [i_max, i_min, _, p_min] = self.limits;
        let level = if intra {
            i64::from(segment.fresh((i_max - i_min + 1) as u32)) + i_min
        } else {
            i64::from(segment.adaptive(&mut self.model)) + p_min
        };
        let amount = if self.step == 0 { level } else { level * self.step };
        self.value = if intra { amount } else { self.value + amount };
    }
}

/// Decodes one segment with the given slots.
fn segment<'s>(bits: &mut Bits, slots: impl Iterator<Item = &'s mut Slot>, intra: bool) -> Result<(), Fault> {
    let mut segment = Segment::open(bits);
    for slot in slots {
        slot.read(&mut segment, intra);
    }
    bits.pos = segment.close()?;
    Ok(())
}

/// FBA-16: the lists whose flags are set; `groups` yields groups of (slot, selected).
fn new_limits(bits: &mut Bits, flags: [bool; 4], groups: &[Vec<(usize, bool)>], slots: &mut [Slot]) -> Result<(), Fault> {
    for list in (0..4).filter(|&list| flags[list]) {
        for group in groups {
            for (place, &(slot, selected)) in group.iter().enumerate() {
                if place % 4 == 0 {
                    bits.marker("FBA-16")?;
                }
                if selected {
                    slots[slot].sent[list] = UNITS[list] * i64::from(bits.take(5, "FBA-16")?);
                }
            }
        }
    }
    Ok(())
}

fn four_flags(bits: &mut Bits) -> Result<[bool; 4], Fault> {
    let mut flags = [false; 4];
    for flag in &mut flags {
        *flag = bits.flag("FBA-13")?;
    }
    Ok(flags)
}

/// FBA-14: what the masks in force say of a FAP.
#[derive(Clone, Copy, PartialEq)]
enum Mask {
    Coded,
    Kept,
    Interpolated,
}

/// FBA-34.
#[derive(Clone, Copy, PartialEq)]
pub enum State {
    Transmitted,
    Retained,
    Interpolated,
    Unset,
}

impl State {
    pub fn letter(self) -> char {
        match self {
            State::Transmitted => 'T',
            State::Retained => 'R',
            State::Interpolated => 'I',
            State::Unset => 'U',
        }
    }

    pub fn has_value(self) -> bool {
        matches!(self, State::Transmitted | State::Retained)
    }
}

pub struct Face {
    pub seen: bool,
    viseme: [Slot; 3],
    expression: [Slot; 4],
    low_level: Vec<Slot>,
    flags: [bool; 3],
    masks: [Mask; 68],
    decoded: [bool; 68],
    pub states: [State; 68],
}

impl Face {
    pub fn new() -> Self {
        let outward = |limit: i64| (limit + 59).div_euclid(60) * 60;
        let low_level = LOW_LEVEL.iter().map(|&(_, intra, inter)| {
            let (intra, inter) = (outward(intra), outward(inter));
            Slot { sent: [intra, -intra, inter, -inter], ..Slot::default() }
        });
        Face {
            seen: false,
            viseme: Default::default(),
            expression: Default::default(),
            low_level: low_level.collect(),
            flags: [false; 3],
            masks: [Mask::Kept; 68],
            decoded: [false; 68],
            states: [State::Unset; 68],
        }
    }

    fn header(&mut self, bits: &mut Bits) -> Result<(), Fault> {
        let quant = i64::from(bits.take(5, "FBA-9")?);
        for (first, count) in FAP_GROUPS {
            bits.marker("FBA-10")?;
            let kind = bits.take(2, "FBA-10")?;
            let (word, off) = match kind {
                0 => (0, Mask::Kept),
                1 => (bits.take(count, "FBA-10")?, Mask::Kept),
                2 => (bits.take(count, "FBA-10")?, Mask::Interpolated),
                _ => (u32::MAX, Mask::Kept),
            };
            for i in 0..count {
                let coded = word >> (count - 1 - i) & 1 == 1;
                self.masks[first - 1 + i] = if coded { Mask::Coded } else { off };
            }
        }
        bits.flag("FBA-11")?;
        if bits.flag("FBA-12")? {
            return fault("Unsupported", "FBA-12", bits.back(1));
        }
        let flags = four_flags(bits)?;
        let groups: Vec<Vec<(usize, bool)>> = FAP_GROUPS[1..]
            .iter()
            .map(|&(first, count)| (first..first + count).map(|fap| (fap - 3, self.coded(fap))).collect())
            .collect();
        new_limits(bits, flags, &groups, &mut self.low_level)?;
        for (i, slot) in self.low_level.iter_mut().enumerate() {
            if self.masks[i + 2] == Mask::Coded {
                slot.prepare(slot.sent.map(|limit| limit / quant.max(1)), LOW_LEVEL[i].0 * quant);
            }
        }
        let most = if quant == 0 { 63 } else { (63 + quant / 2) / quant };
        if self.coded(1) {
            for (slot, (top, step)) in self.viseme.iter_mut().zip([(14, 1), (14, 1), (most, quant)]) {
                slot.prepare([top, 0, top, -top], step);
            }
        }
        if self.coded(2) {
            let forms = [(6, 1), (most, quant), (6, 1), (most, quant)];
            for (slot, (top, step)) in self.expression.iter_mut().zip(forms) {
                slot.prepare([top, 0, top, -top], step);
            }
        }
        Ok(())
    }

    fn coded(&self, fap: usize) -> bool {
        self.masks[fap - 1] == Mask::Coded
    }

    /// The FAP data of a plane.
    pub fn read(&mut self, bits: &mut Bits, intra: bool) -> Result<(), Fault> {
        if intra {
            self.header(bits)?;
            self.seen = true;
        }
        if self.coded(1) {
            let start = bits.pos;
            segment(bits, self.viseme.iter_mut(), intra)?;
            if self.viseme[..2].iter().any(|select| !(0..=14).contains(&select.value)) {
                return fault("RangeViolation", "FBA-32", start..bits.pos);
            }
            self.flags[0] = bits.flag("FBA-28")?;
        }
        if self.coded(2) {
            let start = bits.pos;
            segment(bits, self.expression.iter_mut(), intra)?;
            if self.expression.iter().step_by(2).any(|select| !(0..=6).contains(&select.value)) {
                return fault("RangeViolation", "FBA-32", start..bits.pos);
            }
            self.flags[1] = bits.flag("FBA-28")?;
            self.flags[2] = bits.flag("FBA-28")?;
        }
        let masks = self.masks;
        let coded = self.low_level.iter_mut().zip(&masks[2..]).filter(|(_, &mask)| mask == Mask::Coded);
        segment(bits, coded.map(|(slot, _)| slot), intra)?;
        for i in 0..68 {
            self.decoded[i] |= masks[i] == Mask::Coded;
            self.states[i] = match masks[i] {
                Mask::Coded => State::Transmitted,
                Mask::Interpolated => State::Interpolated,
                Mask::Kept if self.decoded[i] => State::Retained,
                Mask::Kept => State::Unset,
            };
        }
        Ok(())
    }

    /// A plane without FAP data passed.
    pub fn pass(&mut self) {
        for state in self.states.iter_mut().filter(|state| **state == State::Transmitted) {
            *state = State::Retained;
        }
    }

    pub fn value(&self, fap: usize) -> i64 {
        self.low_level[fap - 3].value
    }

    /// The words of CNF-1.
    pub fn viseme(&self) -> String {
        let [select1, select2, blend] = [0, 1, 2].map(|i| self.viseme[i].value);
        let def = u8::from(self.flags[0]);
        format!("{{\"select1\":{select1},\"select2\":{select2},\"blend\":{blend},\"def\":{def}}}")
    }

    pub fn expression(&self) -> String {
        let [select1, intensity1, select2, intensity2] = [0, 1, 2, 3].map(|i| self.expression[i].value);
        let [init_face, def] = [1, 2].map(|i| u8::from(self.flags[i]));
        format!(
            "{{\"select1\":{select1},\"intensity1\":{intensity1},\"select2\":{select2},\"intensity2\":{intensity2},\
             \"init_face\":{init_face},\"def\":{def}}}"
        )
    }
}

/// FBA-40. Slots stand in coding order.
pub struct Body {
    pub seen: bool,
    slots: Vec<Slot>,
    coded: Vec<usize>,
}

impl Body {
    pub fn new() -> Self {
        let slot = |&bap: &usize| Slot { sent: BAP_LIMITS.get(bap - 1).copied().unwrap_or([0; 4]), ..Slot::default() };
        Body { seen: false, slots: BAP_ORDER.iter().map(slot).collect(), coded: Vec::new() }
    }

    pub fn read(&mut self, bits: &mut Bits, intra: bool) -> Result<(), Fault> {
        if intra {
            self.header(bits)?;
            self.seen = true;
        }
        let mut coded = self.coded.iter().peekable();
        let slots = self.slots.iter_mut().enumerate();
        segment(bits, slots.filter(|(i, _)| coded.next_if_eq(&i).is_some()).map(|(_, slot)| slot), intra)
    }

    fn header(&mut self, bits: &mut Bits) -> Result<(), Fault> {
        let scale = BAP_SCALE[bits.take(5, "FBA-40")? as usize];
        let mut groups = Vec::new();
        let mut first = 0;
        for count in BAP_GROUPS {
            bits.marker("FBA-40")?;
            let word = match bits.take(2, "FBA-40")? {
                0 => 0,
                1 => bits.take(count, "FBA-40")?,
                2 => return fault("ForbiddenValue", "FBA-40", bits.back(2)),
                _ => u32::MAX,
            };
            groups.push((0..count).map(|i| (first + i, word >> (count - 1 - i) & 1 == 1)).collect::<Vec<_>>());
            first += count;
        }
        bits.flag("FBA-40")?;
        if bits.flag("FBA-40")? {
            return fault("Unsupported", "FBA-40", bits.back(1));
        }
        let start = bits.pos;
        let flags = four_flags(bits)?;
        new_limits(bits, flags, &groups, &mut self.slots)?;
        self.coded = groups.iter().flatten().filter(|(_, selected)| *selected).map(|(slot, _)| *slot).collect();
        let has_defaults = |&slot: &usize| BAP_ORDER[slot] <= BAP_LIMITS.len();
        if flags.contains(&false) && !self.coded.iter().all(has_defaults) {
            return fault("Unsupported", "FBA-40", start..bits.pos);
        }
        for &i in &self.coded {
            let base = BAP_BASE.get(BAP_ORDER[i] - 1).copied().unwrap_or(1);
            let slot = &mut self.slots[i];
            slot.prepare(slot.sent.map(|limit| limit / scale.max(1)), base * scale);
        }
        Ok(())
    }

    /// Number and value of the coded BAPs, in coding order.
    pub fn values(&self) -> impl Iterator<Item = (usize, i64)> + '_ {
        self.coded.iter().map(|&i| (BAP_ORDER[i], self.slots[i].value))
    }
}
