//! Headers, object, planes, output (SYS-1..7, FBA-1..8, FBA-35, FBA-37..42, FBA-44, CNF-1).

use std::fmt::Write as _;
use std::io::Write;

use crate::bits::{fault, Bits, Fault, Stop};
use crate::parameters::{Body, Face};
use crate::time::Time;

const MAX_SKIPPED: u64 = 1_000_000;
const MAX_IDLE: u32 = 1024;
const OBJECT: u32 = 0x1BA;
const PLANE: u32 = 0x1BB;
const MESH_OBJECT: u32 = 0x1BC;

/// What the decoder found at a plane boundary.
enum Next {
    Plane { start_code: bool },
    End,
}

struct Rate {
    sixteenths: u64,
    offset: bool,
}

struct Plane {
    start: usize,
    intra: bool,
    faps: bool,
    baps: bool,
    time: Time,
}

struct Decoder<'d> {
    bits: Bits<'d>,
    face: Face,
    body: Body,
    rate: Rate,
    time: Time,
}

/// Decodes a stream; complete lines are written as they come.
pub fn decode(data: &[u8], out: &mut impl Write) -> Result<(), Stop> {
    let mut bits = Bits::new(data);
    find_object(&mut bits)?;
    writeln!(out, "{{\"format\":\"snhc-decoded\",\"version\":1,\"kind\":\"fba\"}}")?;
    let mut decoder = Decoder {
        bits,
        face: Face::new(),
        body: Body::new(),
        rate: Rate { sixteenths: 30 * 16, offset: false },
        time: Time::seconds(0),
    };
    let mut idle = 0;
    let mut index = 0u64;
    while let Next::Plane { start_code } = decoder.boundary(index == 0)? {
        let plane = decoder.plane()?;
        idle = match (plane.faps || plane.baps, start_code) {
            (true, _) => 0,
            (false, true) => 1,
            (false, false) => idle + 1,
        };
        if idle > MAX_IDLE {
            fault("ResourceLimit", "FBA-42", plane.start..decoder.bits.pos)?;
        }
        out.write_all(decoder.line(index, &plane).as_bytes())?;
        index += 1;
    }
    Ok(())
}

/// Reads a start code with its prefix, whatever it is.
fn code(bits: &mut Bits) -> Result<u32, Fault> {
    bits.take(32, "SYS-1")
}

/// SYS-5: the next start code that is not user data.
fn code_behind_user_data(bits: &mut Bits) -> Result<u32, Fault> {
    loop {
        let start = bits.pos;
        let found = code(bits)?;
        if found != 0x1B2 {
            return Ok(found);
        }
        match (bits.pos..bits.end).step_by(8).find(|&at| bits.look(at, 24) == Some(1)) {
            Some(at) => bits.pos = at,
            None => return fault("Truncated", "SYS-5", start..bits.end),
        }
    }
}

/// SYS-1..7: leaves the position behind the object start code.
fn find_object(bits: &mut Bits) -> Result<(), Fault> {
    match bits.look(0, 32) {
        None => return fault("InputFormat", "FBA-44", 0..bits.end),
        Some(OBJECT) => {
            bits.pos = 32;
            return Ok(());
        }
        Some(MESH_OBJECT) => return fault("Unsupported", "SYS-7", 0..32),
        Some(0x1B0) => bits.pos = 32,
        Some(0x100..=0x12F | 0x1BE) => return fault("Unsupported", "SYS-4", 0..32),
        Some(0x1B1 | 0x1B2 | 0x1B5 | PLANE | 0x1BD) => return fault("InconsistentSemantics", "SYS-7", 0..32),
        Some(_) => return fault("InputFormat", "FBA-1", 0..32),
    }
    bits.take(8, "SYS-2")?;
    let mut inside = code_behind_user_data(bits)?;
    // A sequence may end without objects, and another may follow.
    while inside == 0x1B1 && bits.look(bits.pos, 32) == Some(0x1B0) {
        bits.pos += 32;
        bits.take(8, "SYS-2")?;
        inside = code_behind_user_data(bits)?;
    }
    if inside != 0x1B5 {
        return fault("InconsistentSemantics", "SYS-2", bits.back(32));
    }
    if bits.flag("SYS-3")? {
        bits.take(4, "SYS-3")?;
        if bits.take(3, "SYS-3")? == 0 {
            return fault("ReservedValue", "SYS-3", bits.back(3));
        }
    }
    let wanted = match bits.take(4, "SYS-4")? {
        3 => MESH_OBJECT,
        4 => OBJECT,
        1 | 2 | 5 => return fault("Unsupported", "SYS-4", bits.back(4)),
        _ => return fault("ReservedValue", "SYS-4", bits.back(4)),
    };
    match bits.behind_stuffing() {
        Some(at) => bits.pos = at,
        None => return fault("ForbiddenValue", "SYS-3", bits.pos..(bits.pos / 8 + 1) * 8),
    }
    if code_behind_user_data(bits)? != wanted {
        return fault("InconsistentSemantics", "SYS-6", bits.back(32));
    }
    if wanted == MESH_OBJECT {
        return fault("Unsupported", "SYS-4", bits.back(32));
    }
    Ok(())
}

impl Decoder<'_> {
    /// FBA-3, FBA-42, FBA-44.
    fn boundary(&mut self, first: bool) -> Result<Next, Fault> {
        let bits = &mut self.bits;
        if bits.pos >= bits.last_one {
            return Ok(Next::End);
        }
        if let Some(at) = bits.behind_stuffing() {
            if at == bits.end {
                return Ok(Next::End);
            }
            if bits.look(at, 24) == Some(1) {
                return match bits.look(at, 32) {
                    None => fault("Truncated", "FBA-44", at..bits.end),
                    Some(PLANE) => {
                        bits.pos = at + 32;
                        Ok(Next::Plane { start_code: true })
                    }
                    Some(_) => Ok(Next::End),
                };
            }
        }
        let start_code = first && bits.look(bits.pos, 32) == Some(PLANE);
        if start_code {
            bits.pos += 32;
        }
        Ok(Next::Plane { start_code })
    }

    /// FBA-5.
    fn plane(&mut self) -> Result<Plane, Fault> {
        let start = self.bits.pos;
        let intra = self.bits.flag("FBA-5")?;
        let mask = self.bits.take(2, "FBA-5")?;
        let (faps, baps) = (mask & 1 != 0, mask & 2 != 0);
        if !intra && (faps && !self.face.seen || baps && !self.body.seen) {
            return fault("InconsistentSemantics", "FBA-35", start..start + 1);
        }
        let time = self.temporal_header(intra)?;
        if faps {
            self.face.read(&mut self.bits, intra)?;
        } else {
            self.face.pass();
        }
        if baps {
            self.body.read(&mut self.bits, intra)?;
        }
        Ok(Plane { start, intra, faps, baps, time })
    }

    fn field(&mut self, count: usize, most: u32) -> Result<u32, Fault> {
        let value = self.bits.take(count, "FBA-7")?;
        if value > most {
            return fault("ForbiddenValue", "FBA-7", self.bits.back(count));
        }
        Ok(value)
    }

    /// FBA-6..8, FBA-37, FBA-38: the time of this plane; the running time goes on to the next.
    fn temporal_header(&mut self, intra: bool) -> Result<Time, Fault> {
        if intra && self.bits.flag("FBA-6")? {
            let frames = u64::from(self.bits.take(8, "FBA-6")?);
            let sixteenths = u64::from(self.bits.take(4, "FBA-6")?) + 16 * frames;
            let offset = self.bits.flag("FBA-6")?;
            if sixteenths == 0 {
                return fault("ForbiddenValue", "FBA-37", self.bits.back(13));
            }
            self.rate = Rate { sixteenths, offset };
        }
        if intra && self.bits.flag("FBA-7")? {
            let hours = self.field(5, 23)?;
            let minutes = self.field(6, 59)?;
            self.bits.marker("FBA-7")?;
            let seconds = self.field(6, 59)?;
            self.time = Time::seconds((hours * 60 + minutes) * 60 + seconds);
        }
        let mut skipped = 0;
        if self.bits.flag("FBA-8")? {
            let start = self.bits.pos;
            loop {
                let part = u64::from(self.bits.take(4, "FBA-8")?);
                skipped += part;
                if skipped > MAX_SKIPPED {
                    return fault("ResourceLimit", "FBA-8", start..self.bits.pos);
                }
                if part != 15 {
                    break;
                }
            }
        }
        let now = self.time.clone();
        let (slow, fast) = if self.rate.offset { (1001, 1000) } else { (1, 1) };
        self.time.advance((skipped + 1) * 16 * slow, self.rate.sixteenths * fast);
        Ok(now)
    }

    /// CNF-1.
    fn line(&self, index: u64, plane: &Plane) -> String {
        let face = &self.face;
        let faps: Vec<String> = (1..=68)
            .map(|fap| match face.states[fap - 1].has_value() && fap > 2 {
                true => face.value(fap).to_string(),
                false => "null".to_string(),
            })
            .collect();
        let shown = |fap: usize, text: String| if face.states[fap - 1].has_value() { text } else { "null".to_string() };
        let mut line = format!(
            "{{\"index\":{index},\"time\":\"{}\",\"intra\":{},\"faps\":[{}],\"viseme\":{},\"expression\":{},\"state\":\"{}\"",
            plane.time,
            plane.intra,
            faps.join(","),
            shown(1, face.viseme()),
            shown(2, face.expression()),
            face.states.iter().map(|state| state.letter()).collect::<String>(),
        );
        if plane.baps {
            let mut baps: Vec<(usize, i64)> = self.body.values().collect();
            baps.sort_unstable();
            let pairs: Vec<String> = baps.iter().map(|(bap, value)| format!("\"{bap}\":{value}")).collect();
            let _ = write!(line, ",\"baps\":{{{}}}", pairs.join(","));
        }
        line.push_str("}\n");
        line
    }
}
