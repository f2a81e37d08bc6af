//! Cycles of a Cortex-M4F per instruction, from the tables in ARM's technical reference
//! manual of the core and its FPU (DDI 0439), for memory without wait states.
//!
//! Where the table gives a range the upper end is taken: a store costs 2 although a free
//! write buffer makes it 1, divisions take their longest, two loads in a row never
//! overlap. What the pipeline does with a stall is approximated in [`stalls_next`].

use crate::disassembly::Instruction;

/// Kind of instruction, as the report groups them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Integer arithmetic, logic, moves, and whatever is not below.
    Integer,
    /// 32-bit multiply and multiply-add.
    Multiply,
    /// Integer division.
    Divide,
    /// Single and double integer load.
    Load,
    /// Single and double integer store.
    Store,
    /// `ldm` and `pop`.
    LoadMany,
    /// `stm` and `push`.
    StoreMany,
    /// Jump, call, return.
    Branch,
    /// Float addition and subtraction.
    FloatAdd,
    /// Float multiplication.
    FloatMultiply,
    /// Fused or chained multiply-add.
    FloatMultiplyAdd,
    /// Float division.
    FloatDivide,
    /// Float square root.
    FloatRoot,
    /// Float load.
    FloatLoad,
    /// Float store.
    FloatStore,
    /// `vldm` and `vpop`.
    FloatLoadMany,
    /// `vstm` and `vpush`.
    FloatStoreMany,
    /// Float moves, comparisons, conversions.
    FloatOther,
}

/// Cost of one instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// How the report groups it.
    pub class: Class,
    /// Cycles of every execution.
    pub cycles: u64,
    /// More cycles when the next instruction executed is not the next in memory.
    pub if_taken: u64,
}

/// Cycles to refill the pipeline after a jump.
const REFILL: u64 = 2;

/// More cycles when a load, not a branch, writes the program counter.
const LOAD_PC: u64 = 3;

/// Looks an instruction up.
pub fn timing(instruction: &Instruction<'_>) -> Timing {
    if instruction.is_float() {
        float_timing(instruction)
    } else {
        integer_timing(instruction)
    }
}

fn float_timing(instruction: &Instruction<'_>) -> Timing {
    let is = |prefix: &str| instruction.mnemonic.starts_with(prefix);
    let is_any = |prefixes: &[&str]| prefixes.iter().any(|prefix| is(prefix));
    let words = if instruction.first_operand().starts_with('d') {
        2
    } else {
        1
    };
    let (class, cycles) = if is_any(&["vldm", "vpop"]) {
        (Class::FloatLoadMany, 1 + instruction.listed_words())
    } else if is_any(&["vstm", "vpush"]) {
        (Class::FloatStoreMany, 1 + instruction.listed_words())
    } else if is("vldr") {
        (Class::FloatLoad, 1 + words)
    } else if is("vstr") {
        (Class::FloatStore, 1 + words)
    } else if is("vdiv") {
        (Class::FloatDivide, 14)
    } else if is("vsqrt") {
        (Class::FloatRoot, 14)
    } else if is_any(&[
        "vfma", "vfms", "vfnma", "vfnms", "vmla", "vmls", "vnmla", "vnmls",
    ]) {
        (Class::FloatMultiplyAdd, 3)
    } else if is_any(&["vmul", "vnmul"]) {
        (Class::FloatMultiply, 1)
    } else if is_any(&["vadd", "vsub"]) {
        (Class::FloatAdd, 1)
    } else {
        (Class::FloatOther, 1)
    };
    Timing {
        class,
        cycles,
        if_taken: 0,
    }
}

fn integer_timing(instruction: &Instruction<'_>) -> Timing {
    let is = |prefix: &str| instruction.mnemonic.starts_with(prefix);
    let is_any = |prefixes: &[&str]| prefixes.iter().any(|prefix| is(prefix));
    let if_loads_pc = |loads_pc: bool| if loads_pc { LOAD_PC } else { 0 };
    let (class, cycles, if_taken) = if is_any(&["pop", "ldm"]) {
        (
            Class::LoadMany,
            1 + instruction.listed_words(),
            if_loads_pc(instruction.names_pc()),
        )
    } else if is_any(&["push", "stm"]) {
        (Class::StoreMany, 1 + instruction.listed_words(), 0)
    } else if is("ldrd") {
        (Class::Load, 3, 0)
    } else if is("strd") {
        (Class::Store, 3, 0)
    } else if is("ldr") {
        (
            Class::Load,
            2,
            if_loads_pc(instruction.first_operand() == "pc"),
        )
    } else if is("str") {
        (Class::Store, 2, 0)
    } else if is_any(&["sdiv", "udiv"]) {
        (Class::Divide, 12, 0)
    } else if is_any(&["mla", "mls"]) {
        (Class::Multiply, 2, 0)
    } else if is_any(&["mul", "smull", "umull", "smlal", "umlal", "umaal"]) {
        (Class::Multiply, 1, 0)
    } else if is_any(&["tbb", "tbh"]) {
        (Class::Branch, 2, REFILL + 1)
    } else if is_branch(instruction.mnemonic) {
        (Class::Branch, 1, REFILL)
    } else {
        (Class::Integer, 1, 0)
    };
    Timing {
        class,
        cycles,
        if_taken,
    }
}

/// `cbz`, `cbnz`, and `b`, `bl`, `bx`, `blx` with or without a condition, but not `bic` or `bfi`.
fn is_branch(mnemonic: &str) -> bool {
    const CONDITIONS: [&str; 17] = [
        "eq", "ne", "cs", "hs", "cc", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt",
        "le", "al",
    ];
    matches!(mnemonic, "cbz" | "cbnz")
        || ["b", "bl", "bx", "blx"].into_iter().any(|stem| {
            mnemonic
                .strip_prefix(stem)
                .is_some_and(|condition| condition.is_empty() || CONDITIONS.contains(&condition))
        })
}

/// Whether `second`, right after `first`, waits a cycle for its result: floating-point
/// arithmetic hands its result over one cycle late.
pub fn stalls_next(first: &Instruction<'_>, second: &Instruction<'_>) -> bool {
    use Class::{FloatAdd, FloatDivide, FloatMultiply, FloatMultiplyAdd, FloatRoot, FloatStore};
    let (before, after) = (timing(first), timing(second));
    let computes = matches!(
        before.class,
        FloatAdd | FloatMultiply | FloatMultiplyAdd | FloatDivide | FloatRoot
    ) || (before.class == Class::FloatOther
        && !first.mnemonic.starts_with("vcmp")
        && !first.mnemonic.starts_with("vmrs"));
    if !computes || !second.is_float() {
        return false;
    }
    // Multiply-adds, comparisons and stores read their first operand too.
    let reads_first =
        matches!(after.class, FloatMultiplyAdd | FloatStore) || second.mnemonic.starts_with("vcmp");
    let result = first.first_operand();
    !result.is_empty()
        && second
            .operands()
            .skip(usize::from(!reads_first))
            .any(|operand| operand == result)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look_up(line: &str) -> (Class, u64, u64) {
        let found = timing(&Instruction::parse(line));
        (found.class, found.cycles, found.if_taken)
    }

    #[test]
    fn float_arithmetic() {
        assert_eq!(look_up("vadd.f32 s0, s1, s2"), (Class::FloatAdd, 1, 0));
        assert_eq!(look_up("vmul.f32 s0, s1, s2"), (Class::FloatMultiply, 1, 0));
        assert_eq!(
            look_up("vfma.f32 s0, s1, s2"),
            (Class::FloatMultiplyAdd, 3, 0)
        );
        assert_eq!(
            look_up("vnmls.f32 s0, s1, s2"),
            (Class::FloatMultiplyAdd, 3, 0)
        );
        assert_eq!(look_up("vdiv.f32 s0, s1, s2"), (Class::FloatDivide, 14, 0));
        assert_eq!(look_up("vsqrt.f32 s0, s1"), (Class::FloatRoot, 14, 0));
        assert_eq!(look_up("vmrs apsr_nzcv, fpscr"), (Class::FloatOther, 1, 0));
    }

    #[test]
    fn memory() {
        assert_eq!(look_up("ldr r0, [r1]"), (Class::Load, 2, 0));
        assert_eq!(look_up("ldr.w pc, [r1, r2, lsl #2]"), (Class::Load, 2, 3));
        assert_eq!(look_up("strd r0, r1, [sp]"), (Class::Store, 3, 0));
        assert_eq!(look_up("vldr s0, [r0, #4]"), (Class::FloatLoad, 2, 0));
        assert_eq!(look_up("vldr d0, [r0, #8]"), (Class::FloatLoad, 3, 0));
        assert_eq!(look_up("vldmia r0!, {s0-s3}"), (Class::FloatLoadMany, 5, 0));
        assert_eq!(look_up("vpush {d8, d9}"), (Class::FloatStoreMany, 5, 0));
        assert_eq!(look_up("pop {r4, r5, pc}"), (Class::LoadMany, 4, 3));
        assert_eq!(look_up("stm.w r0, {r1, r2}"), (Class::StoreMany, 3, 0));
    }

    #[test]
    fn branches_are_told_from_bit_operations() {
        assert_eq!(look_up("bne #0x100"), (Class::Branch, 1, 2));
        assert_eq!(look_up("bl #0x100"), (Class::Branch, 1, 2));
        assert_eq!(look_up("bls #0x100"), (Class::Branch, 1, 2));
        assert_eq!(look_up("cbz r0, #0x100"), (Class::Branch, 1, 2));
        assert_eq!(look_up("bx lr"), (Class::Branch, 1, 2));
        assert_eq!(look_up("bxne lr"), (Class::Branch, 1, 2));
        assert_eq!(look_up("bic r0, r1, #1"), (Class::Integer, 1, 0));
        assert_eq!(look_up("bfi r0, r1, #0, #4"), (Class::Integer, 1, 0));
    }

    #[test]
    fn integer_arithmetic() {
        assert_eq!(look_up("adds r0, r1, #1"), (Class::Integer, 1, 0));
        assert_eq!(look_up("mul r0, r1, r2"), (Class::Multiply, 1, 0));
        assert_eq!(look_up("mla r0, r1, r2, r3"), (Class::Multiply, 2, 0));
        assert_eq!(look_up("udiv r0, r1, r2"), (Class::Divide, 12, 0));
    }

    #[test]
    fn a_float_result_used_at_once_stalls() {
        let stalls =
            |first, second| stalls_next(&Instruction::parse(first), &Instruction::parse(second));
        assert!(stalls("vmul.f32 s0, s1, s2", "vadd.f32 s3, s3, s0"));
        assert!(stalls("vadd.f32 s0, s1, s2", "vstr s0, [r0]"));
        assert!(
            stalls("vmul.f32 s0, s1, s2", "vmla.f32 s0, s3, s4"),
            "the accumulator is read"
        );
        assert!(
            !stalls("vmul.f32 s0, s1, s2", "vadd.f32 s0, s3, s4"),
            "the result is overwritten"
        );
        assert!(
            !stalls("vldr s0, [r0]", "vadd.f32 s3, s3, s0"),
            "loads hand over in time"
        );
        assert!(!stalls("vmul.f32 s0, s1, s2", "adds r0, #1"));
    }
}
