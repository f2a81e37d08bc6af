//! What the flash adds to the time of a program: the wait states that are left behind the chip's
//! accelerator, for the blocks that an image has executed.
//!
//! For two banks: the flash gives 8 bytes a read; an instruction cache of 1 KB and a data cache of
//! 256 bytes; prefetch reads the next 8 bytes while these are executed (RM0440). Lines of four times
//! 8 bytes are those of the STM32L4, which has the same accelerator. What is said nowhere is taken
//! so: the line used longest ago is replaced, a line is filled 8 bytes at a time as they are asked
//! for, and a read that has begun is ended before the next. Data are those that lie in the program
//! beside it (a load relative to the program counter); tables that are reached by a pointer are not
//! seen.

use object::{Object, ObjectSegment};

use crate::{Failure, Result};

/// Bytes of one read of the flash.
const READ: u32 = 8;
/// Reads in a line of a cache.
const READS: u32 = 4;
/// Lines of the caches of instructions and of data.
const LINES: (usize, usize) = (32, 8);
/// Cycles of a read at 163.2 MHz: one, and four wait states.
const READ_CYCLES: f64 = 5.0;
/// Where the flash lies.
const FLASH: core::ops::Range<u32> = 0x0800_0000..0x0808_0000;

/// How the program is read.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// The next 8 bytes are read ahead.
    pub prefetch: bool,
    /// Cycles of an instruction with memory that never waits, in the mean.
    pub cycles_per_instruction: f64,
}

/// What a program took.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Taken {
    /// Instructions.
    pub instructions: u64,
    /// Cycles, waiting included.
    pub cycles: f64,
    /// Cycles of waiting for instructions.
    pub waited: f64,
    /// Cycles of waiting for data beside the program.
    pub waited_for_data: f64,
}

/// A cache: lines by their number, with which reads of them are there.
struct Cache {
    lines: Vec<(u32, u8)>,
    most: usize,
}

impl Cache {
    fn new(most: usize) -> Self {
        Self {
            lines: Vec::with_capacity(most),
            most,
        }
    }

    /// Whether a read is there; its line is then the one used last.
    fn has(&mut self, read: u32) -> bool {
        let (line, bit) = (read / READS, 1 << (read % READS));
        let Some(place) = self.lines.iter().position(|&(number, _)| number == line) else {
            return false;
        };
        self.lines[place..].rotate_left(1);
        self.lines
            .last()
            .is_some_and(|&(_, there)| there & bit != 0)
    }

    fn take(&mut self, read: u32) {
        let (line, bit) = (read / READS, 1 << (read % READS));
        match self.lines.iter_mut().find(|(number, _)| *number == line) {
            Some((_, there)) => *there |= bit,
            None => {
                if self.lines.len() == self.most {
                    self.lines.remove(0);
                }
                self.lines.push((line, bit));
            }
        }
    }
}

/// The flash, its caches, and how far the program has come.
struct Accelerator {
    setup: Setup,
    instructions: Cache,
    data: Cache,
    /// The read whose bytes are being executed.
    current: Option<u32>,
    /// The read ahead, and when it ends.
    ahead: Option<(u32, f64)>,
    /// When the flash has ended its last read.
    free: f64,
    taken: Taken,
}

impl Accelerator {
    /// Begins a read as soon as the flash can; when it ends.
    fn read(&mut self) -> f64 {
        self.free = self.free.max(self.taken.cycles) + READ_CYCLES;
        self.free
    }

    /// Waits until a moment; how long. What arrives within a cycle costs nothing.
    fn wait(&mut self, end: f64) -> f64 {
        let waited = (end - 1.0 - self.taken.cycles).max(0.0);
        self.taken.cycles += waited;
        waited
    }

    fn fetch(&mut self, read: u32) {
        if self.current == Some(read) {
            return;
        }
        self.current = Some(read);
        if self.instructions.has(read) {
            return;
        }
        let end = match self.ahead.take() {
            Some((there, end)) if there == read => end,
            _ => self.read(),
        };
        self.taken.waited += self.wait(end);
        self.instructions.take(read);
        if self.setup.prefetch && !self.instructions.has(read + 1) {
            self.ahead = Some((read + 1, self.read()));
        }
    }

    fn load(&mut self, read: u32) {
        if !self.data.has(read) {
            let end = self.read();
            self.taken.waited_for_data += self.wait(end);
            self.data.take(read);
        }
    }
}

/// Runs blocks (address and bytes each) of a program through the accelerator. `halfword` gives the
/// program's halfword at an address of the flash.
pub fn run(
    blocks: impl IntoIterator<Item = (u32, u32)>,
    halfword: impl Fn(u32) -> u16,
    setup: Setup,
) -> Taken {
    let mut flash = Accelerator {
        setup,
        instructions: Cache::new(LINES.0),
        data: Cache::new(LINES.1),
        current: None,
        ahead: None,
        free: 0.0,
        taken: Taken::default(),
    };
    for (address, bytes) in blocks {
        let mut at = address;
        while at < address + bytes {
            let first = halfword(at);
            let long = first >> 11 > 0b11100;
            let length = if long { 4 } else { 2 };
            if FLASH.contains(&at) {
                flash.fetch(at / READ);
                flash.fetch((at + length - 1) / READ);
            }
            let second = if long { halfword(at + 2) } else { 0 };
            if let Some(there) = literal(at, first, second).filter(|a| FLASH.contains(a)) {
                flash.load(there / READ);
            }
            flash.taken.instructions += 1;
            flash.taken.cycles += setup.cycles_per_instruction;
            at += length;
        }
    }
    flash.taken
}

/// What an image has in the flash, from its start.
///
/// # Errors
/// It is no ELF file.
pub fn program(elf: &[u8]) -> Result<Vec<u8>> {
    let file = object::File::parse(elf)
        .map_err(|why| Failure::new("the image is no ELF file").because(why))?;
    let mut flash = vec![0xFF; FLASH.len()];
    for segment in file.segments() {
        let at = segment.address() as u32;
        if FLASH.contains(&at) {
            let bytes = segment
                .data()
                .map_err(|why| Failure::new("the image is cut short").because(why))?;
            let from = (at - FLASH.start) as usize;
            if let Some(place) = flash.get_mut(from..from + bytes.len()) {
                place.copy_from_slice(bytes);
            }
        }
    }
    Ok(flash)
}

/// The halfword at an address, of [`program`]'s flash.
pub fn halfword(flash: &[u8], at: u32) -> u16 {
    let from = at.wrapping_sub(FLASH.start) as usize;
    match flash.get(from..from.saturating_add(2)) {
        Some(&[low, high]) => u16::from_le_bytes([low, high]),
        _ => 0,
    }
}

/// Address of the data that an instruction loads relative to the program counter.
fn literal(at: u32, first: u16, second: u16) -> Option<u32> {
    let base = (at + 4) & !3;
    let signed = |offset: u32| {
        if first & 0x80 != 0 {
            base + offset
        } else {
            base - offset
        }
    };
    if first >> 11 == 0b01001 {
        return Some(base + u32::from(first & 0xFF) * 4);
    }
    match first & 0xFF7F {
        // LDR of a word, then VLDR of one and of two.
        0xF85F => Some(signed(u32::from(second & 0xFFF))),
        _ if first & 0xFF3F == 0xED1F && matches!(second >> 8 & 0xF, 0xA | 0xB) => {
            Some(signed(u32::from(second & 0xFF) * 4))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOP: u16 = 0xBF00;

    fn taken(blocks: &[(u32, u32)], prefetch: bool) -> Taken {
        let setup = Setup {
            prefetch,
            cycles_per_instruction: 1.0,
        };
        run(blocks.iter().copied(), |_| NOP, setup)
    }

    /// Four instructions a read: each read waits four cycles; with prefetch the next one is on its
    /// way meanwhile, and one cycle is left to wait.
    #[test]
    fn a_straight_line_waits_for_every_read() {
        let line = [(0x0800_0000, 8 * 100)];
        let bare = taken(&line, false);
        assert_eq!((bare.instructions, bare.waited), (400, 400.0));
        let ahead = taken(&line, true);
        assert_eq!(ahead.waited, 4.0 + 99.0);
        assert_eq!(ahead.cycles, 400.0 + 103.0);
    }

    /// What fits the cache waits once; one line more than fits, used in turn, always.
    #[test]
    fn a_loop_that_fits_the_cache_waits_once() {
        let fits = [(0x0800_0000, 1024); 50];
        assert_eq!(taken(&fits, false).waited, 4.0 * 128.0);
        let longer = [(0x0800_0000, 1024 + 32); 50];
        assert_eq!(taken(&longer, false).waited, 4.0 * 132.0 * 50.0);
    }

    #[test]
    fn memory_never_waits() {
        let all = taken(&[(0x2000_0000, 4000)], true);
        assert_eq!((all.instructions, all.cycles), (2000, 2000.0));
    }

    /// `ldr r0, [pc, #4]` and `vldr s0, [pc, #-8]`, as the manual of the architecture codes them.
    #[test]
    fn data_beside_the_program_are_found() {
        assert_eq!(literal(0x0800_0002, 0x4801, 0), Some(0x0800_0008));
        assert_eq!(literal(0x0800_0010, 0xED1F, 0x0A02), Some(0x0800_000C));
        assert_eq!(literal(0x0800_0010, 0xF8DF, 0x0008), Some(0x0800_001C));
        assert_eq!(literal(0x0800_0010, NOP, 0), None);
        let one = |at: u32| if at.is_multiple_of(8) { 0x4801 } else { NOP };
        let setup = Setup {
            prefetch: false,
            cycles_per_instruction: 1.0,
        };
        let seen = run([(0x0800_0000, 2), (0x0800_0000, 2)], one, setup);
        // The word lies beside the instruction: the caches are apart, and the flash is still ending
        // the read of the one when the other is asked for.
        assert_eq!((seen.waited, seen.waited_for_data), (4.0, 5.0));
    }
}
