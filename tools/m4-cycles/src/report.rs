//! The report: totals, a line per class, the addresses that were executed.
//!
//! ```text
//! instructions 30020
//! cycles 45030
//! class FloatAdd instructions 2000 cycles 2000
//! executed 1a4
//! ```

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::disassembly::Instruction;
use crate::timing::{Class, stalls_next, timing};
use crate::trace::Site;

/// Instructions and estimated cycles of one class, or of all.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Sum {
    /// Instructions executed.
    pub instructions: u64,
    /// Estimated cycles, stalls included.
    pub cycles: u64,
}

impl Sum {
    fn add(&mut self, instructions: u64, cycles: u64) {
        self.instructions += instructions;
        self.cycles += cycles;
    }
}

/// Sums by class over sites sorted by address.
pub fn by_class(sites: &[&Site]) -> BTreeMap<Class, Sum> {
    let mut sums: BTreeMap<Class, Sum> = BTreeMap::new();
    for (index, site) in sites
        .iter()
        .enumerate()
        .filter(|(_, site)| site.executed() > 0)
    {
        let instruction = Instruction::parse(&site.line);
        let cost = timing(&instruction);
        let stalls = sites
            .get(index + 1)
            .filter(|next| next.address == site.next_address() && next.executed() > 0)
            .is_some_and(|next| stalls_next(&instruction, &Instruction::parse(&next.line)));
        let cycles =
            site.executed() * (cost.cycles + u64::from(stalls)) + site.taken() * cost.if_taken;
        sums.entry(cost.class)
            .or_default()
            .add(site.executed(), cycles);
    }
    sums
}

/// The text of the report over sites sorted by address.
pub fn text(sites: &[&Site]) -> String {
    let classes = by_class(sites);
    let mut all = Sum::default();
    for sum in classes.values() {
        all.add(sum.instructions, sum.cycles);
    }
    let mut text = format!("instructions {}\ncycles {}\n", all.instructions, all.cycles);
    for (class, sum) in &classes {
        // Writing to a String cannot fail.
        let _ = writeln!(
            text,
            "class {class:?} instructions {} cycles {}",
            sum.instructions, sum.cycles
        );
    }
    for site in sites.iter().filter(|site| site.executed() > 0) {
        let _ = writeln!(text, "executed {:x}", site.address);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trace::Trace;

    /// A loop of two rounds: multiply, add that waits for it, branch back.
    #[test]
    fn sums_cycles_stalls_and_taken_branches() {
        let trace = Trace::new(0x10, 0x1a);
        let lines = [
            (0x10, 4, "vmul.f32 s0, s1, s2"),
            (0x14, 4, "vadd.f32 s3, s3, s0"),
            (0x18, 2, "bne #0x10"),
            (0x1a, 2, "nop"),
        ];
        let at = |index: usize| {
            let (address, size, line) = lines[index];
            trace.site(address, || Site::new(address, size, line.to_owned()))
        };
        for index in [0, 1, 2, 0, 1, 2, 3] {
            trace.execute(at(index));
        }
        let sites = trace.sites();
        let sums = by_class(&sites);
        assert_eq!(
            sums[&Class::FloatMultiply],
            Sum {
                instructions: 2,
                cycles: 4
            }
        );
        assert_eq!(
            sums[&Class::FloatAdd],
            Sum {
                instructions: 2,
                cycles: 2
            }
        );
        assert_eq!(
            sums[&Class::Branch],
            Sum {
                instructions: 2,
                cycles: 4
            }
        );
        let text = text(&sites);
        assert!(text.starts_with("instructions 6\ncycles 10\n"), "{text}");
        assert!(
            text.ends_with("executed 10\nexecuted 14\nexecuted 18\n"),
            "{text}"
        );
    }
}
