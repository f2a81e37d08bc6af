//! The program of an image where it runs, decoded: in the flash, or copied to memory at start.

use std::path::Path;

use object::{Architecture, Object, ObjectSegment};

use super::instruction::{Instruction, Kind};
use crate::{Failure, Result};

/// Where the flash lies.
pub const FLASH: core::ops::Range<u32> = 0x0800_0000..0x0808_0000;
/// Where the core fetches from its coupled memory, which never waits.
pub const COUPLED: core::ops::Range<u32> = 0x1000_0000..0x1000_8000;
/// Where the stack may begin.
const MEMORY: core::ops::RangeInclusive<u32> = 0x2000_0000..=0x2002_0000;

/// A stretch of memory that holds instructions: where, and the one that begins at each halfword.
#[derive(Debug, Clone)]
struct Part {
    from: u32,
    instructions: Vec<Instruction>,
}

/// The program.
#[derive(Debug, Clone)]
pub struct Program(Vec<Part>);

impl Program {
    /// Reads an image's file.
    ///
    /// # Errors
    /// It is not there, or [`Program::read`]'s.
    pub fn read_file(path: &Path) -> Result<Self> {
        Self::read(&bytes_of(path)?)
            .map_err(|why| Failure::new(format!("{}: {why}", path.display())))
    }

    /// Reads an image.
    ///
    /// # Errors
    /// It is no ELF file, or no image for this chip.
    pub fn read(elf: &[u8]) -> Result<Self> {
        let file = object::File::parse(elf)
            .map_err(|why| Failure::new("the image is no ELF file").because(why))?;
        if file.architecture() != Architecture::Arm || file.is_64() {
            return Err(Failure::new(format!(
                "the image is for {:?}, not for the Cortex-M4 of an STM32G474",
                file.architecture()
            )));
        }
        let mut program = Self(Vec::new());
        let mut vectors = None;
        for segment in file.segments() {
            let at = segment.address() as u32;
            let bytes = segment
                .data()
                .map_err(|why| Failure::new("the image is cut short").because(why))?;
            if at == FLASH.start {
                vectors = bytes.get(..8);
            }
            if FLASH.contains(&at) || COUPLED.contains(&at) {
                let pairs = bytes.chunks_exact(2);
                let halfwords: Vec<u16> = pairs.map(|p| u16::from_le_bytes([p[0], p[1]])).collect();
                program.0.extend(Self::of_halfwords(at, &halfwords).0);
            }
        }
        let word = |at: usize| {
            let bytes = vectors.and_then(|v| v.get(at..at + 4))?;
            Some(u32::from_le_bytes(bytes.try_into().ok()?))
        };
        match (word(0), word(4)) {
            (Some(stack), Some(reset)) if MEMORY.contains(&stack) && program.holds(reset & !1) => {
                Ok(program)
            }
            _ => Err(Failure::new(
                "the image is for another chip: no vectors of an STM32G474 at 0x8000000",
            )
            .advise("give the one that `cargo fw build nucleo-g474re` makes")),
        }
    }

    /// A program that lies in one piece.
    pub fn of_halfwords(from: u32, halfwords: &[u16]) -> Self {
        let next = halfwords.iter().skip(1).chain(&[0]);
        let instructions = halfwords
            .iter()
            .zip(next)
            .map(|(&first, &second)| Instruction::decode(first, second))
            .collect();
        Self(vec![Part { from, instructions }])
    }

    /// Every word of an image's parts, wherever it begins on a halfword.
    ///
    /// # Errors
    /// The file cannot be read, or is no ELF file.
    pub fn words(path: &Path) -> Result<Vec<u32>> {
        let elf = bytes_of(path)?;
        let file = object::File::parse(elf.as_slice())
            .map_err(|why| Failure::new("the image is no ELF file").because(why))?;
        let parts = file.segments().filter_map(|part| part.data().ok());
        let each = parts.flat_map(|bytes| bytes.windows(4).step_by(2));
        let words = each.map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]]));
        Ok(words.collect())
    }

    fn find(&self, at: u32) -> Option<Instruction> {
        self.0.iter().find_map(|part| {
            let place = at.checked_sub(part.from)? as usize / 2;
            part.instructions.get(place).copied()
        })
    }

    /// Whether an address lies in it.
    pub fn holds(&self, at: u32) -> bool {
        self.find(at).is_some()
    }

    /// The instruction at an address; one that does nothing where there is none.
    pub fn at(&self, at: u32) -> Instruction {
        self.find(at).unwrap_or(Instruction {
            bytes: 2,
            kind: Kind::Plain,
        })
    }
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path)
        .map_err(|why| Failure::new(format!("cannot read {}", path.display())).because(why))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of 32-bit little-endian ELF with one segment.
    fn elf(machine: u16, address: u32, words: &[u32]) -> Vec<u8> {
        let length = 4 * words.len() as u32;
        let head: [u32; 6] = [
            0x464C_457F,
            0x0001_0101,
            0,
            0,
            u32::from(machine) << 16 | 2,
            1,
        ];
        let rest: [u32; 7] = [0, 52, 0, 0x0500_0000, 0x0020_0034, 0x0000_0001, 0];
        let segment: [u32; 8] = [1, 84, address, address, length, length, 5, 4];
        let all = head.iter().chain(&rest).chain(&segment).chain(words);
        all.flat_map(|word| word.to_le_bytes()).collect()
    }

    #[test]
    fn an_image_for_another_chip_is_refused() {
        const ARM: u16 = 40;
        let good = [0x2000_8800, 0x0800_0009, 0xBF00_BF00];
        let read = |machine, at, words: &[u32]| Program::read(&elf(machine, at, words));
        let program = read(ARM, 0x0800_0000, &good).expect("an image for this chip");
        assert!(program.holds(0x0800_000A) && !program.holds(0x0800_000C));
        // The emulated board's: flash at 0.
        let why = |read: Result<Program>| read.unwrap_err().to_string();
        assert!(why(read(ARM, 0, &good)).contains("another chip"));
        // A stack where this chip has no memory.
        let other = [0x1000_8000, good[1], good[2]];
        assert!(why(read(ARM, 0x0800_0000, &other)).contains("another chip"));
        // 32-bit x86.
        assert!(why(read(3, 0x0800_0000, &good)).contains("not for the Cortex-M4"));
        assert!(why(Program::read(b"no ELF")).contains("no ELF"));
    }
}
