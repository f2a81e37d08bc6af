//! Where the time goes: the cycles of what was executed, by function.

use std::collections::HashMap;
use std::fmt::Write as _;

use super::program::Program;
use super::timing::{Machine, Setup, Taken};
use super::trace::{Step, Trace};
use crate::arm_image::ArmImage;

/// What one function took.
#[derive(Debug, Clone, PartialEq)]
pub struct Share {
    /// The function, without its crate's hash; the address where no symbol covers it.
    pub name: String,
    /// Bytes of its code.
    pub bytes: u64,
    /// What it took, what it called not included.
    pub taken: Taken,
}

/// What each function took of a trace, the most first. The cycles of an exception's entry and return are
/// in the function that is entered and left.
pub fn by_function(image: &ArmImage, program: &Program, trace: &Trace, setup: Setup) -> Vec<Share> {
    let mut machine = Machine::new(program, setup);
    let mut shares: HashMap<u64, Share> = HashMap::new();
    let mut starts: HashMap<u32, u64> = HashMap::new();
    let mut now = 0;
    let mut before = Taken::default();
    for &step in &trace.steps {
        if let Step::Run(at) = step {
            now = *starts
                .entry(at)
                .or_insert_with(|| start(image, at, &mut shares));
        }
        machine.step(step);
        let after = machine.taken();
        if let Some(share) = shares.get_mut(&now) {
            share.taken = share.taken + (after - before);
        }
        before = after;
    }
    let mut shares: Vec<Share> = shares.into_values().collect();
    shares.sort_by_key(|share| std::cmp::Reverse(share.taken.cycles));
    shares
}

/// Where the function that holds an address begins; it has a share from then on.
fn start(image: &ArmImage, at: u32, shares: &mut HashMap<u64, Share>) -> u64 {
    let function = image.holding(u64::from(at));
    let (start, name, bytes) = match function {
        Some(f) => (f.code.start, short(&f.name), f.code.end - f.code.start),
        None => (u64::from(at), format!("{at:#x}"), 0),
    };
    shares.entry(start).or_insert_with(|| Share {
        name,
        bytes,
        taken: Taken::default(),
    });
    start
}

/// A linked name as it is written in the source, as far as that can be told.
fn short(name: &str) -> String {
    let plain = format!("{:#}", rustc_demangle::demangle(name));
    plain.replace("<impl ", "<").chars().take(90).collect()
}

/// The functions with at least a hundredth of the cycles, as a table: each per `samples`.
pub fn markdown(shares: &[Share], samples: f64) -> String {
    let all: u64 = shares.iter().map(|share| share.taken.cycles).sum();
    let mut text = "| function | bytes | instructions a sample | cycles | of these waiting |\n\
        |---|---:|---:|---:|---:|\n"
        .to_owned();
    for share in shares
        .iter()
        .filter(|share| share.taken.cycles * 100 >= all)
    {
        let taken = share.taken;
        let per = |count: u64| count as f64 / samples;
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "| `{}` | {} | {:.1} | {:.1} | {:.1} |",
            share.name,
            share.bytes,
            per(taken.instructions),
            per(taken.cycles),
            per(taken.waited + taken.waited_for_data)
        );
    }
    text
}
