//! What the commands must know of a board: its core, how its image is built, what runs it.

use crate::toolchain::{ARM, ARM_V8, Target};
use crate::{EMULATED_BOARD, EMULATED_M33};

/// A board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Its name: that of its memory map, its feature and its binary.
    pub name: &'static str,
    /// What its images are built for.
    pub target: Target,
    /// The cargo profile of its images: where flash is small or slow, the small one.
    pub profile: &'static str,
    /// What runs its images.
    pub runner: Runner,
}

/// What runs an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Runner {
    /// QEMU, as this machine.
    Qemu(Machine),
    /// A program that flashes the board, and how it is called before the path of the image.
    Flasher {
        /// On the search path.
        program: &'static str,
        /// Cargo's runner.
        line: &'static str,
        /// What to do where it is missing.
        advice: &'static str,
    },
}

/// A machine that QEMU emulates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Machine {
    /// Cortex-M4F.
    An386,
    /// Cortex-M33.
    An505,
}

/// Where the program begins on [`Machine::An505`]: its memory by its secure address.
const AN505_PROGRAM: u64 = 0x1000_0000;

impl Machine {
    /// The one that an image is for, by the address of its first instruction.
    pub fn of_entry(entry: u64) -> Self {
        if entry < AN505_PROGRAM {
            Self::An386
        } else {
            Self::An505
        }
    }

    /// QEMU's options.
    pub fn options(self) -> [&'static str; 4] {
        match self {
            Self::An386 => ["-cpu", "cortex-m4", "-machine", "mps2-an386"],
            Self::An505 => ["-cpu", "cortex-m33", "-machine", "mps2-an505"],
        }
    }
}

/// Every board.
pub const ALL: [Board; 4] = [
    Board {
        name: EMULATED_BOARD,
        target: ARM,
        profile: "fw",
        runner: Runner::Qemu(Machine::An386),
    },
    Board {
        name: EMULATED_M33,
        target: ARM_V8,
        profile: "fw",
        runner: Runner::Qemu(Machine::An505),
    },
    Board {
        name: "nucleo-g474re",
        target: ARM,
        profile: "fw-small",
        runner: Runner::Flasher {
            program: "probe-rs",
            line: "probe-rs run --chip STM32G474RETx",
            advice: "`cargo install probe-rs-tools --locked`, then connect the board by USB",
        },
    },
    Board {
        name: "pico2",
        target: ARM_V8,
        profile: "fw-small",
        runner: Runner::Flasher {
            program: "picotool",
            line: "picotool load --update --verify --execute -t elf",
            advice: "install picotool 2 or later, then connect the board by USB while BOOTSEL is held down",
        },
    },
];

impl Board {
    /// The board of that name.
    pub fn of(name: &str) -> Option<&'static Self> {
        ALL.iter().find(|board| board.name == name)
    }

    /// Whether QEMU runs it.
    pub fn is_emulated(&self) -> bool {
        matches!(self.runner, Runner::Qemu(_))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boards_have_names_of_their_own_and_runners_that_begin_with_their_program() {
        for (k, board) in ALL.iter().enumerate() {
            assert_eq!(Board::of(board.name), Some(&ALL[k]));
            if let Runner::Flasher { program, line, .. } = board.runner {
                assert!(line.starts_with(program), "{line}");
                assert_eq!(board.profile, "fw-small", "{}", board.name);
            }
        }
        assert_eq!(Board::of("other"), None);
    }

    #[test]
    fn machines_are_told_by_where_the_program_lies() {
        assert_eq!(Machine::of_entry(0x401), Machine::An386);
        assert_eq!(Machine::of_entry(0x1000_0401), Machine::An505);
    }
}
