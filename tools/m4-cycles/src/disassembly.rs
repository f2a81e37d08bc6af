//! Reads the line of disassembly that QEMU gives for an instruction.

/// One disassembled instruction, e.g. `vadd.f32 s0, s1, s2`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Instruction<'a> {
    /// The mnemonic without a width suffix (`ldr`, never `ldr.w`).
    pub mnemonic: &'a str,
    operands: &'a str,
}

impl<'a> Instruction<'a> {
    /// Splits a line into mnemonic and operands.
    pub fn parse(line: &'a str) -> Self {
        let line = line.trim();
        let (mnemonic, operands) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let mnemonic = mnemonic
            .strip_suffix(".w")
            .or_else(|| mnemonic.strip_suffix(".n"))
            .unwrap_or(mnemonic);
        Self {
            mnemonic,
            operands: operands.trim(),
        }
    }

    /// Operands in order, brackets of addresses kept.
    pub fn operands(&self) -> impl Iterator<Item = &'a str> {
        self.operands
            .split(',')
            .map(str::trim)
            .filter(|operand| !operand.is_empty())
    }

    /// The first operand: the destination of most instructions.
    pub fn first_operand(&self) -> &'a str {
        self.operands().next().unwrap_or("")
    }

    /// Whether the program counter is among the operands.
    pub fn names_pc(&self) -> bool {
        self.operands
            .split(|c: char| !c.is_ascii_alphanumeric())
            .any(|word| word == "pc")
    }

    /// 32-bit words in the register list `{…}`: a double register is two.
    pub fn listed_words(&self) -> u64 {
        let list = self
            .operands
            .split('{')
            .nth(1)
            .and_then(|rest| rest.split('}').next())
            .unwrap_or("");
        list.split(',')
            .map(str::trim)
            .filter(|item| !item.is_empty())
            .map(words_in)
            .sum()
    }

    /// Whether this is a floating-point instruction.
    pub fn is_float(&self) -> bool {
        self.mnemonic.starts_with('v')
    }
}

/// Words in one item of a register list: `r4`, `s0-s3`, `d8`.
fn words_in(item: &str) -> u64 {
    let number = |register: &str| {
        register
            .trim()
            .trim_start_matches(|c: char| c.is_ascii_alphabetic())
            .parse::<u64>()
            .ok()
    };
    let registers = match item
        .split_once('-')
        .map(|(first, last)| (number(first), number(last)))
    {
        Some((Some(first), Some(last))) => last.abs_diff(first) + 1,
        _ => 1,
    };
    if item.starts_with('d') {
        2 * registers
    } else {
        registers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_mnemonic_and_operands() {
        let load = Instruction::parse("  ldr.w    r3, [r4, #0x10]");
        assert_eq!(load.mnemonic, "ldr");
        assert_eq!(load.operands().collect::<Vec<_>>(), ["r3", "[r4", "#0x10]"]);
        assert_eq!(Instruction::parse("nop").first_operand(), "");
    }

    #[test]
    fn counts_words_of_register_lists() {
        let words = |line| Instruction::parse(line).listed_words();
        assert_eq!(words("push {r4, r5, r6, r7, lr}"), 5);
        assert_eq!(words("push.w {r4-r7, lr}"), 5);
        assert_eq!(words("vpush {d8, d9}"), 4);
        assert_eq!(words("vldmia r0!, {s0-s7}"), 8);
        assert_eq!(words("adds r0, #1"), 0);
    }

    #[test]
    fn sees_the_program_counter_only_as_a_word() {
        assert!(Instruction::parse("pop {r4, pc}").names_pc());
        assert!(!Instruction::parse("pop {r4, r5}").names_pc());
        assert!(!Instruction::parse("bl #0x1234").names_pc());
    }
}
