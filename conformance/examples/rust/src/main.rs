//! CNF-9: `fba-decoder INPUT`. Exit 0: accepted, 1: rejected (one JSON line on standard error), 3: files, 2: usage.

mod bits;
mod coder;
mod parameters;
mod stream;
mod tables;
mod time;

use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use bits::Stop;

fn main() -> ExitCode {
    let names: Vec<_> = std::env::args_os().skip(1).collect();
    let [name] = names.as_slice() else {
        eprintln!("usage: fba-decoder INPUT");
        return ExitCode::from(2);
    };
    let data = match std::fs::read(name) {
        Ok(data) => data,
        Err(error) => {
            eprintln!("fba-decoder: {}: {error}", name.to_string_lossy());
            return ExitCode::from(3);
        }
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let ended = stream::decode(&data, &mut out);
    let flushed = out.flush();
    match ended.and(flushed.map_err(Stop::from)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Fault(fault)) => {
            let (first, end) = (fault.bits.start, fault.bits.end);
            eprintln!("{{\"class\":\"{}\",\"rule\":\"{}\",\"bits\":[{first},{end}]}}", fault.class, fault.rule);
            ExitCode::from(1)
        }
        Err(Stop::Output(error)) => {
            eprintln!("fba-decoder: standard output: {error}");
            ExitCode::from(3)
        }
    }
}
