//! What the model of the chip has executed, step by step (tools/g474-model/trace.py).

use std::path::Path;

use super::program::Program;
use crate::{Failure, Result};

/// The mark at the beginning of a file, with the number of its form.
const BEGIN: [u32; 2] = [0x3434_4B54, 0xFF00_0001];

/// One thing that the core did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Executed the instruction at an address.
    Run(u32),
    /// It loaded from this address of the flash.
    Load(u32),
    /// It stored into this register of a peripheral.
    Store(u32),
    /// Entered the handler of an exception.
    Enter {
        /// Its number.
        number: u32,
        /// When, in ticks.
        at: u64,
    },
    /// Returned from it.
    Leave,
    /// Went to sleep.
    Sleep,
    /// Woke.
    Wake {
        /// When, in ticks.
        at: u64,
    },
}

/// A stretch of the program.
#[derive(Debug, Clone, Default)]
pub struct Trace {
    /// Its steps.
    pub steps: Vec<Step>,
    /// Whether interrupts are masked as it begins.
    pub masked: bool,
}

impl Trace {
    /// Reads a file of the model.
    ///
    /// # Errors
    /// It is not there, was cut short, or executes what is not in the program.
    pub fn read(path: &Path, program: &Program) -> Result<Self> {
        let bytes = std::fs::read(path)
            .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))?;
        Self::parse(&bytes, program)
            .map_err(|why| Failure::new(format!("{}: {why}", path.display())))
    }

    /// Reads the bytes of such a file.
    ///
    /// # Errors
    /// Says what is wrong with them.
    pub fn parse(bytes: &[u8], program: &Program) -> std::result::Result<Self, String> {
        let number = |bytes: &[u8]| bytes.iter().rev().fold(0, |n, &b| n << 8 | u32::from(b));
        let records: Vec<[u32; 2]> = bytes
            .chunks_exact(8)
            .map(|record| [number(&record[..4]), number(&record[4..])])
            .collect();
        let [begin, records @ .., end] = records.as_slice() else {
            return Err("no trace: it is empty".to_owned());
        };
        if *begin != BEGIN {
            return Err("no trace of the model of the chip, or one of another version".to_owned());
        }
        if *end != [records.len() as u32, 8 << 24] || !bytes.len().is_multiple_of(8) {
            return Err(format!(
                "the trace ends early, after {} records: the model was stopped, or its disk was full",
                records.len() + 1
            ));
        }
        let mut reader = Reader::new(program);
        for &[value, word] in records {
            reader.take(value, word >> 24, word & 0xFF_FFFF)?;
        }
        reader.flush();
        Ok(reader.trace)
    }

    /// Instructions executed.
    pub fn instructions(&self) -> u64 {
        let run = |step: &&Step| matches!(step, Step::Run(_));
        self.steps.iter().filter(run).count() as u64
    }

    /// The part from the first execution of one address to the first of another, after it.
    pub fn between(&self, first: u32, last: u32) -> Option<Self> {
        let place = |of: u32, from: usize| {
            let found = self.steps[from..].iter().position(|s| *s == Step::Run(of));
            found.map(|place| from + place)
        };
        let from = place(first, 0)?;
        let to = place(last, from + 1)?;
        Some(Self {
            steps: self.steps[from..to].to_vec(),
            masked: self.masked,
        })
    }
}

/// A block is known whole when the next record is: the program may have left it early.
struct Reader<'a> {
    program: &'a Program,
    trace: Trace,
    block: Option<(u32, u32)>,
    /// Loads and stores of the block, by the instruction whose address ends so.
    accesses: Vec<(Step, u32)>,
    /// The last moment; files have 32 bits of it.
    now: u64,
}

impl<'a> Reader<'a> {
    fn new(program: &'a Program) -> Self {
        Self {
            program,
            trace: Trace::default(),
            block: None,
            accesses: Vec::new(),
            now: 0,
        }
    }

    fn take(&mut self, value: u32, kind: u32, detail: u32) -> std::result::Result<(), String> {
        match kind {
            0 => {
                self.flush();
                if !self.program.holds(value) {
                    return Err(format!(
                        "it executes {value:#x}, where the image has no program: another image's trace"
                    ));
                }
                self.block = Some((value, value + detail));
            }
            1 => self.accesses.push((Step::Load(value), detail)),
            9 => self.accesses.push((Step::Store(value), detail)),
            4 => {
                if let Some((from, to)) = &mut self.block
                    && (*from..*to).contains(&value)
                {
                    *to = value;
                }
            }
            7 => self.trace.masked = value != 0,
            2 | 3 | 5 | 6 => {
                self.flush();
                self.now += u64::from(value.wrapping_sub(self.now as u32));
                let at = self.now;
                self.trace.steps.push(match kind {
                    2 => Step::Enter { number: detail, at },
                    3 => Step::Leave,
                    5 => Step::Sleep,
                    _ => Step::Wake { at },
                });
            }
            _ => return Err(format!("a record of an unknown kind, {kind}")),
        }
        Ok(())
    }

    fn flush(&mut self) {
        let Some((mut at, to)) = self.block.take() else {
            return;
        };
        let mut accesses = self.accesses.drain(..).peekable();
        while at < to {
            self.trace.steps.push(Step::Run(at));
            while let Some((step, _)) = accesses.next_if(|(_, by)| *by == at & 0xFF_FFFF) {
                self.trace.steps.push(step);
            }
            at += u32::from(self.program.at(at).bytes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program() -> Program {
        // nop, ldr r0, [r1], nop …
        Program::of_halfwords(0x0800_0000, &[0xBF00, 0x6808, 0xBF00, 0xBF00])
    }

    fn file(records: &[[u32; 2]]) -> Vec<u8> {
        let end = [records.len() as u32, 8 << 24];
        let all = [&[BEGIN], records, &[end]].concat();
        all.iter().flatten().flat_map(|n| n.to_le_bytes()).collect()
    }

    const BLOCK: [u32; 2] = [0x0800_0000, 8];

    #[test]
    fn loads_follow_their_instruction_and_a_block_that_is_left_ends_there() {
        let load = [0x0800_4000, 1 << 24 | 2];
        let left = [0x0800_0004, 4 << 24];
        let read = Trace::parse(&file(&[[1, 7 << 24], BLOCK, load, left]), &program()).unwrap();
        let steps = [
            Step::Run(0x0800_0000),
            Step::Run(0x0800_0002),
            Step::Load(0x0800_4000),
        ];
        assert_eq!(read.steps, steps);
        assert!(read.masked);
        assert_eq!(read.instructions(), 2);
    }

    #[test]
    fn moments_go_on_beyond_32_bits() {
        let records = [[0xFFFF_FFF0, 6 << 24], [16, 2 << 24 | 28]];
        let read = Trace::parse(&file(&records), &program()).unwrap();
        let enter = Step::Enter {
            number: 28,
            at: 0x1_0000_0010,
        };
        assert_eq!(read.steps, [Step::Wake { at: 0xFFFF_FFF0 }, enter]);
    }

    #[test]
    fn a_file_that_is_cut_or_anothers_is_refused() {
        let whole = file(&[BLOCK, BLOCK]);
        let why = |bytes: &[u8]| Trace::parse(bytes, &program()).unwrap_err();
        for cut in [3, 8, 12] {
            assert!(
                why(&whole[..whole.len() - cut]).contains("ends early"),
                "{cut}"
            );
        }
        assert!(why(&[]).contains("empty"));
        assert!(why(&whole[8..]).contains("another version"));
        assert!(why(&file(&[[0x0800_1000, 8]])).contains("another image's"));
    }
}
