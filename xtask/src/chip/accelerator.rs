//! What the flash adds to the time of a program: the wait states that are left behind the chip's
//! accelerator.
//!
//! For two banks: the flash gives 8 bytes a read; an instruction cache of 1 KB and a data cache of
//! 256 bytes; prefetch reads the next 8 bytes while these are executed (RM0440). Lines of four times
//! 8 bytes are those of the STM32L4, which has the same accelerator. What is said nowhere is taken
//! so: the line used longest ago is replaced, a line is filled 8 bytes at a time as they are asked
//! for, and a read that has begun is ended before the next.

/// Bytes of one read of the flash.
const READ: u32 = 8;
/// Reads in a line of a cache.
const READS: u32 = 4;
/// Lines of the caches of instructions and of data.
const LINES: (usize, usize) = (32, 8);
/// Cycles of a read at 163.2 MHz: one, and four wait states.
const READ_CYCLES: u64 = 5;

/// A cache: lines by their number, with which reads of them are there.
#[derive(Debug, Clone)]
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

/// The flash and its caches, cold.
#[derive(Debug, Clone)]
pub struct Flash {
    prefetch: bool,
    instructions: Cache,
    data: Cache,
    /// The read whose bytes are being executed.
    current: Option<u32>,
    /// The read ahead, and when it ends.
    ahead: Option<(u32, u64)>,
    /// When the flash has ended its last read.
    free: u64,
}

impl Flash {
    /// Whether the next 8 bytes are read ahead.
    pub fn new(prefetch: bool) -> Self {
        Self {
            prefetch,
            instructions: Cache::new(LINES.0),
            data: Cache::new(LINES.1),
            current: None,
            ahead: None,
            free: 0,
        }
    }

    /// Begins a read as soon as the flash can; when it ends.
    fn read(&mut self, now: u64) -> u64 {
        self.free = self.free.max(now) + READ_CYCLES;
        self.free
    }

    /// Cycles that the core waits for an instruction at an address. What arrives within a cycle costs
    /// nothing.
    pub fn fetch(&mut self, at: u32, now: u64) -> u64 {
        let read = at / READ;
        if self.current == Some(read) {
            return 0;
        }
        self.current = Some(read);
        if self.instructions.has(read) {
            return 0;
        }
        let end = match self.ahead.take() {
            Some((there, end)) if there == read => end,
            _ => self.read(now),
        };
        let waited = (end - 1).saturating_sub(now);
        self.instructions.take(read);
        if self.prefetch && !self.instructions.has(read + 1) {
            self.ahead = Some((read + 1, self.read(now + waited)));
        }
        waited
    }

    /// Cycles that it waits for data there.
    pub fn load(&mut self, at: u32, now: u64) -> u64 {
        let read = at / READ;
        if self.data.has(read) {
            return 0;
        }
        let end = self.read(now);
        self.data.take(read);
        (end - 1).saturating_sub(now)
    }
}
