//! What an instruction of the image is to a model of its time: Thumb as the manual of ARMv7-M codes
//! it, sorted by what ARM's table of cycles tells apart.

/// Kind of instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Arithmetic, logic, moves, multiplications, and whatever is not below.
    Plain,
    /// `mla`, `mls`.
    MultiplyAdd,
    /// `udiv`, `sdiv`.
    Divide,
    /// One register or two from or to memory.
    Memory {
        /// From memory.
        load: bool,
        /// Registers, 1 or 2.
        words: u8,
        /// The register of the address.
        base: u8,
        /// The register that a load of a single one writes.
        written: Option<u8>,
    },
    /// Several registers, `pop` and `push`, `vldm` and `vstm` among them.
    Many {
        /// Registers.
        words: u8,
        /// The program counter is one that is loaded.
        to_pc: bool,
    },
    /// A load of the program counter.
    LoadPc,
    /// A jump or call to a place that is coded in it.
    Jump,
    /// A jump to a register: calls of pointers, returns.
    JumpRegister,
    /// `tbb`, `tbh`.
    Table,
    /// `it`.
    If,
    /// `cpsid i`.
    Mask,
    /// `cpsie i`, and `msr primask`, which the image only has to undo a mask.
    Unmask,
    /// `dsb`, `isb`, `dmb`, other work on special registers.
    Special,
    /// Arithmetic of single precision.
    Float(Float),
}

/// A floating-point instruction: the single registers that it writes and reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Float {
    /// What it does.
    pub operation: Operation,
    /// Writes.
    pub result: Option<u8>,
    /// Reads.
    pub reads: [Option<u8>; 2],
    /// Adds to.
    pub addend: Option<u8>,
}

/// What the unit does, as far as its time goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operation {
    /// Sum, product, conversion.
    Arithmetic,
    /// Sum of a product and a register.
    MultiplyAdd,
    /// Quotient or root.
    Long,
    /// Move, sign, comparison.
    Move,
    /// Two registers of the core at once.
    MoveTwo,
    /// From or to memory.
    Memory {
        /// From memory.
        load: bool,
        /// Registers, 1 or 2.
        words: u8,
    },
    /// Several registers from or to memory.
    Many {
        /// Registers.
        words: u8,
    },
}

/// An instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instruction {
    /// Its bytes, 2 or 4.
    pub bytes: u8,
    /// What it is.
    pub kind: Kind,
}

impl Instruction {
    /// Decodes two halfwords; the second is not looked at where one is all.
    pub fn decode(first: u16, second: u16) -> Self {
        // Five leading bits above 0b11100: two halfwords.
        if first >> 11 > 0b11100 {
            let kind = wide(first, second);
            Self { bytes: 4, kind }
        } else {
            let kind = narrow(first);
            Self { bytes: 2, kind }
        }
    }
}

fn memory(load: bool, words: u8, base: u16, register: u16) -> Kind {
    Kind::Memory {
        load,
        words,
        base: base as u8,
        written: (load && words == 1).then_some(register as u8),
    }
}

fn narrow(code: u16) -> Kind {
    let low = |shift: u16| code >> shift & 7;
    let many = |extra: u16| ((code & 0xFF).count_ones() as u16 + extra) as u8;
    match code >> 12 {
        0b0100 => match code {
            0x4700..=0x47FF => Kind::JumpRegister,
            0x4800.. => memory(true, 1, 15, low(8)),
            _ if code & 0xFD87 == 0x4487 => Kind::JumpRegister,
            _ => Kind::Plain,
        },
        // By a register: stores first, then loads.
        0b0101 => memory(code >> 9 & 7 >= 3, 1, low(3), low(0)),
        0b0110..=0b1000 => memory(code >> 11 & 1 == 1, 1, low(3), low(0)),
        0b1001 => memory(code >> 11 & 1 == 1, 1, 13, low(8)),
        0b1011 => match code {
            0xB662 => Kind::Unmask,
            0xB672 => Kind::Mask,
            _ if code & 0xF500 == 0xB100 => Kind::Jump,
            _ if code & 0xFE00 == 0xB400 || code & 0xFE00 == 0xBC00 => Kind::Many {
                words: many(code >> 8 & 1),
                to_pc: code >> 8 == 0xBD,
            },
            _ if code >> 8 == 0xBF && code & 0xF != 0 => Kind::If,
            _ => Kind::Plain,
        },
        0b1100 => Kind::Many {
            words: many(0),
            to_pc: false,
        },
        0b1101 if code >> 8 & 0xF < 14 => Kind::Jump,
        0b1110 => Kind::Jump,
        _ => Kind::Plain,
    }
}

fn wide(first: u16, second: u16) -> Kind {
    let to = second >> 12;
    match first >> 9 {
        // 0xE8, 0xE9.
        0b111_0100 => match first >> 4 & 7 {
            // Without the bit that tells them from several registers.
            0..=3 => Kind::Many {
                words: second.count_ones() as u8,
                to_pc: first >> 4 & 1 == 1 && second >> 15 == 1,
            },
            _ if first & 0x0120 != 0 => memory(first >> 4 & 1 == 1, 2, first & 15, 0),
            _ if first & 0xFFF0 == 0xE8D0 && second & 0xE0 == 0 => Kind::Table,
            _ => memory(first >> 4 & 1 == 1, 1, first & 15, to),
        },
        // 0xEC to 0xEF.
        0b111_0110 | 0b111_0111 if matches!(second >> 8 & 15, 10 | 11) => {
            Kind::Float(float(first, second))
        }
        // 0xF0 to 0xF7.
        0b111_1000..=0b111_1011 if second >> 15 == 1 => {
            if second & 0x5000 != 0 || first >> 7 & 7 != 7 {
                Kind::Jump
            } else if first & 0xFFE0 == 0xF380 && second == 0x8810 {
                Kind::Unmask
            } else {
                Kind::Special
            }
        }
        // 0xF8, 0xF9.
        0b111_1100 => match (first >> 4 & 1 == 1, to) {
            (true, 15) if first & 0xFF60 == 0xF840 => Kind::LoadPc,
            (load, to) => memory(load, 1, first & 15, to),
        },
        // 0xFA, 0xFB.
        0b111_1101 => match first >> 4 & 0xFF {
            0xB0 if to != 15 => Kind::MultiplyAdd,
            0xB9 | 0xBB => Kind::Divide,
            _ => Kind::Plain,
        },
        _ => Kind::Plain,
    }
}

fn float(first: u16, second: u16) -> Float {
    let bit = |word: u16, n: u16| word >> n & 1;
    let d = ((second >> 12) << 1 | bit(first, 6)) as u8;
    let n = ((first & 15) << 1 | bit(second, 7)) as u8;
    let m = ((second & 15) << 1 | bit(second, 5)) as u8;
    let words = 1 + (second >> 8 & 1) as u8;
    let of = |operation, result, reads| Float {
        operation,
        result,
        reads,
        addend: None,
    };
    if first >> 9 == 0b111_0110 {
        let load = bit(first, 4) == 1;
        return if first & 0x0FE0 == 0x0C40 {
            of(Operation::MoveTwo, None, [None; 2])
        } else if first & 0x0120 == 0x0100 {
            let stored = (!load).then_some(d);
            of(Operation::Memory { load, words }, None, [stored, None])
        } else {
            let words = (second & 0xFF) as u8;
            of(Operation::Many { words }, None, [None; 2])
        };
    }
    if bit(second, 4) == 1 {
        // Between the core and one register, or the flags.
        return of(Operation::Move, None, [Some(n), None]);
    }
    let both = [Some(n), Some(m)];
    match first >> 4 & 0b1011 {
        0b0000 | 0b0001 | 0b1001 | 0b1010 => Float {
            operation: Operation::MultiplyAdd,
            result: Some(d),
            reads: both,
            addend: Some(d),
        },
        0b0010 | 0b0011 => of(Operation::Arithmetic, Some(d), both),
        0b1000 => of(Operation::Long, Some(d), both),
        _ => match (first & 15, second >> 6 & 3) {
            (1, 3) => of(Operation::Long, Some(d), [Some(m), None]),
            // Comparisons.
            (4 | 5, _) => of(Operation::Move, None, [Some(d), Some(m)]),
            // Moves of a constant, of a register, signs.
            (0, _) | (1, 1) => of(Operation::Move, None, [Some(m), None]),
            _ if second >> 6 & 1 == 0 => of(Operation::Move, None, [None; 2]),
            _ => of(Operation::Arithmetic, Some(d), [Some(m), None]),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(first: u16, second: u16) -> Kind {
        Instruction::decode(first, second).kind
    }

    /// Words as a disassembler shows them, of a linked image.
    #[test]
    fn integers_are_told_apart() {
        let load = |base, written| Kind::Memory {
            load: true,
            words: 1,
            base,
            written: Some(written),
        };
        let store = |words, base| Kind::Memory {
            load: false,
            words,
            base,
            written: None,
        };
        for (first, second, expected) in [
            (0x4801, 0, load(15, 0)),            // ldr r0, [pc, #4]
            (0x6848, 0, load(1, 0)),             // ldr r0, [r1, #4]
            (0x5C8A, 0, load(1, 2)),             // ldrb r2, [r1, r2]
            (0x9103, 0, store(1, 13)),           // str r1, [sp, #12]
            (0xF8D4, 0x0200, load(4, 0)),        // ldr.w r0, [r4, #512]
            (0xF99D, 0x3005, load(13, 3)),       // ldrsb.w r3, [sp, #5]
            (0xF840, 0x1F04, store(1, 0)),       // str.w r1, [r0, #4]!
            (0xE9CD, 0x0102, store(2, 13)),      // strd r0, r1, [sp, #8]
            (0xE8D1, 0xF002, Kind::Table),       // tbb [r1, r2]
            (0xF85D, 0xFB04, Kind::LoadPc),      // ldr.w pc, [sp], #4
            (0xD1FE, 0, Kind::Jump),             // bne.n
            (0xE7FE, 0, Kind::Jump),             // b.n
            (0xB118, 0, Kind::Jump),             // cbz r0
            (0xF7FF, 0xFFED, Kind::Jump),        // bl
            (0xF000, 0x8012, Kind::Jump),        // beq.w
            (0x4770, 0, Kind::JumpRegister),     // bx lr
            (0x4687, 0, Kind::JumpRegister),     // mov pc, r0
            (0xBF08, 0, Kind::If),               // it eq
            (0xBF00, 0, Kind::Plain),            // nop
            (0xB672, 0, Kind::Mask),             // cpsid i
            (0xB662, 0, Kind::Unmask),           // cpsie i
            (0xF380, 0x8810, Kind::Unmask),      // msr primask, r0
            (0xF3EF, 0x8010, Kind::Special),     // mrs r0, primask
            (0xF3BF, 0x8F4F, Kind::Special),     // dsb
            (0xFBB0, 0xF0F1, Kind::Divide),      // udiv r0, r0, r1
            (0xFB00, 0x1202, Kind::MultiplyAdd), // mla r2, r0, r2, r1
            (0xFB00, 0xF101, Kind::Plain),       // mul.w r1, r0, r1
            (0xFBA0, 0x0101, Kind::Plain),       // umull r0, r1, r0, r1
            (0x4348, 0, Kind::Plain),            // muls r0, r1
            (0xF04F, 0x0600, Kind::Plain),       // mov.w r6, #0
            (0xEBAC, 0x0E03, Kind::Plain),       // sub.w lr, ip, r3
        ] {
            assert_eq!(kind(first, second), expected, "{first:#x} {second:#x}");
        }
        let many = |first, second| match kind(first, second) {
            Kind::Many { words, to_pc } => (words, to_pc),
            other => panic!("{other:?}"),
        };
        assert_eq!(many(0xB5F0, 0), (5, false)); // push {r4-r7, lr}
        assert_eq!(many(0xBDF0, 0), (5, true)); // pop {r4-r7, pc}
        assert_eq!(many(0xE92D, 0x4FF0), (9, false)); // push.w {r4-r11, lr}
        assert_eq!(many(0xE8BD, 0x8FF0), (9, true)); // pop.w {r4-r11, pc}
        assert_eq!(many(0xC807, 0), (3, false)); // ldmia r0!, {r0-r2}
    }

    #[test]
    fn floats_are_told_apart() {
        let float = |first, second| match kind(first, second) {
            Kind::Float(float) => float,
            other => panic!("{other:?}"),
        };
        let memory = float(0xED96, 0x6A00); // vldr s12, [r6]
        let one = Operation::Memory {
            load: true,
            words: 1,
        };
        assert_eq!(memory.operation, one);
        // vstr d0, [sp, #8]
        let two = Operation::Memory {
            load: false,
            words: 2,
        };
        assert_eq!(float(0xED8D, 0x0B02).operation, two);
        // vpush {d8, d9}
        let pushed = float(0xED2D, 0x8B04).operation;
        assert_eq!(pushed, Operation::Many { words: 4 });
        // vmov r0, r1, d0
        assert_eq!(float(0xEC51, 0x0B10).operation, Operation::MoveTwo);
        // vfma.f32 s0, s1, s2
        let sum = float(0xEEA0, 0x0A81);
        assert_eq!(sum.operation, Operation::MultiplyAdd);
        assert_eq!((sum.result, sum.addend), (Some(0), Some(0)));
        assert_eq!(sum.reads, [Some(1), Some(2)]);
        // vadd.f32 s3, s3, s0
        let sum = float(0xEE71, 0x1A80);
        assert_eq!(
            (sum.operation, sum.result),
            (Operation::Arithmetic, Some(3))
        );
        assert_eq!(sum.reads, [Some(3), Some(0)]);
        // vdiv.f32 s0, s1, s2 and vsqrt.f32 s0, s1
        assert_eq!(float(0xEE80, 0x0A81).operation, Operation::Long);
        assert_eq!(float(0xEEB1, 0x0AE0).operation, Operation::Long);
        // vmov.f32 s12, s10; vmov.f32 s0, #1.0; vmrs; vmov s0, r0; vcmp.f32 s0, s1
        for (first, second) in [
            (0xEEB0, 0x6A45),
            (0xEEB7, 0x0A00),
            (0xEEF1, 0xFA10),
            (0xEE00, 0x0A10),
            (0xEEB4, 0x0A60),
        ] {
            assert_eq!(float(first, second).operation, Operation::Move);
        }
        // vcvt.f32.s32 s0, s0
        assert_eq!(float(0xEEB8, 0x0AC0).operation, Operation::Arithmetic);
    }
}
