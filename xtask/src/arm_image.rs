//! What the commands need to know of a linked image.

use std::fs;
use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSection, ObjectSegment, ObjectSymbol, SectionKind, SymbolKind};

use crate::{Failure, Result};

/// What the linker calls a way to a function that a call does not reach, before its name.
const WAY: &str = "__Thumbv7ABSLongThunk_";

/// A function in the image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Function {
    /// Its name as linked.
    pub name: String,
    /// The addresses of its code.
    pub code: Range<u64>,
}

/// An image's functions with their code, and whether it logs.
#[derive(Debug, Clone, Default)]
pub struct ArmImage {
    functions: Vec<Function>,
    /// Address and bytes of every section with code.
    text: Vec<(u64, Vec<u8>)>,
    /// Where code (`true`) and data between it (`false`) begin, by address.
    marks: Vec<(u64, bool)>,
    has_defmt_log: bool,
    entry: u64,
    /// Bytes in flash, and of static memory.
    sizes: (u64, u64),
}

impl ArmImage {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// When the file cannot be read or is no ELF.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = fs::read(path).map_err(|why| {
            Failure::new(format!("cannot read image {}", path.display())).because(why)
        })?;
        let elf = object::File::parse(&*bytes).map_err(|why| {
            Failure::new(format!("{} is no ELF image", path.display())).because(why)
        })?;
        // Bit 0 of a Thumb function's address is no part of where its code lies.
        let mut functions: Vec<Function> = elf
            .symbols()
            .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
            .map(|symbol| {
                let start = symbol.address() & !1;
                let name = symbol.name().unwrap_or_default().to_owned();
                Function {
                    name,
                    code: start..start + symbol.size(),
                }
            })
            .collect();
        functions.sort_by_key(|function| function.code.start);
        let text = elf
            .sections()
            .filter(|section| section.kind() == SectionKind::Text)
            .filter_map(|section| Some((section.address(), section.data().ok()?.to_vec())))
            .collect();
        // Mapping symbols of the ELF for the ARM architecture: $t code, $d data.
        let mut marks: Vec<(u64, bool)> = elf
            .symbols()
            .filter_map(|symbol| match symbol.name().ok()?.get(..2)? {
                "$t" => Some((symbol.address(), true)),
                "$d" => Some((symbol.address(), false)),
                _ => None,
            })
            .collect();
        marks.sort_unstable();
        let sizes = sizes(&elf);
        let has_defmt_log = elf.section_by_name(".defmt").is_some();
        Ok(Self {
            functions,
            text,
            marks,
            has_defmt_log,
            entry: elf.entry(),
            sizes,
        })
    }

    /// Whether what it writes to stdout is a defmt log.
    pub fn has_defmt_log(&self) -> bool {
        self.has_defmt_log
    }

    /// Address of its first instruction.
    pub fn entry(&self) -> u64 {
        self.entry
    }

    /// Bytes that it takes in flash.
    pub fn flash_bytes(&self) -> u64 {
        self.sizes.0
    }

    /// Bytes of its static memory.
    pub fn static_bytes(&self) -> u64 {
        self.sizes.1
    }

    /// The function of that name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
    }

    /// Every name of the function that begins at an address.
    pub fn at(&self, address: u64) -> impl Iterator<Item = &Function> {
        self.functions
            .iter()
            .filter(move |function| function.code.start == address)
    }

    /// The functions that hold at least one of the given addresses.
    pub fn entered<'a>(&'a self, addresses: &'a [u64]) -> impl Iterator<Item = &'a Function> {
        self.functions.iter().filter(|function| {
            addresses
                .iter()
                .any(|address| function.code.contains(address))
        })
    }

    /// The function whose code holds an address.
    pub fn holding(&self, address: u64) -> Option<&Function> {
        let behind = |function: &Function| function.code.start <= address;
        let last = self.functions.partition_point(behind).checked_sub(1)?;
        Some(&self.functions[last]).filter(|function| function.code.contains(&address))
    }

    /// The instructions of a function: address, first halfword, second (0 where there is none).
    pub fn instructions(&self, function: &Function) -> Vec<(u64, u16, u16)> {
        let mut found = Vec::new();
        let mut address = function.code.start;
        while address + 2 <= function.code.end {
            let first = self.halfword(address).filter(|_| self.is_code(address));
            // Five leading bits above 0b11100: an instruction of two halfwords.
            let wide = first.is_some_and(|first| first >> 11 > 0b11100);
            let second = self.halfword(address + 2).filter(|_| wide);
            found.extend(first.map(|first| (address, first, second.unwrap_or_default())));
            address += if wide { 4 } else { 2 };
        }
        found
    }

    /// Targets of the calls and of the jumps out of a function, once for each place. A way that the
    /// linker has put in, for a target that a call does not reach, is seen through.
    pub fn calls(&self, function: &Function) -> Vec<u64> {
        let instructions = self.instructions(function).into_iter();
        let targets =
            instructions.filter_map(|(at, first, second)| branch_target(at, first, second));
        targets
            .filter(|target| !function.code.contains(target))
            .map(|target| self.beyond(target))
            .collect()
    }

    /// Where the linker's way to a far function leads, or the target itself.
    fn beyond(&self, target: u64) -> u64 {
        let far = |way: &Function| {
            let name = way.name.strip_prefix(WAY)?;
            self.function(name).map(|function| function.code.start)
        };
        self.at(target).find_map(far).unwrap_or(target)
    }

    /// Places in a function that call or jump through a register.
    pub fn pointer_calls(&self, function: &Function) -> usize {
        let instructions = self.instructions(function);
        let through = |&&(_, first, _): &&(u64, u16, u16)| is_pointer_call(first);
        instructions.iter().filter(through).count()
    }

    /// The functions whose name, as linked, contains a part; the linker's ways to them are none.
    pub fn named<'a>(&'a self, part: &'a str) -> impl Iterator<Item = &'a Function> {
        self.functions
            .iter()
            .filter(move |function| function.name.contains(part))
            .filter(|function| !function.name.starts_with(WAY))
    }

    fn halfword(&self, address: u64) -> Option<u16> {
        self.text.iter().find_map(|(start, bytes)| {
            let offset = usize::try_from(address.checked_sub(*start)?).ok()?;
            let halfword = bytes.get(offset..offset + 2)?;
            Some(u16::from_le_bytes([halfword[0], halfword[1]]))
        })
    }

    fn is_code(&self, address: u64) -> bool {
        let next = self.marks.partition_point(|(start, _)| *start <= address);
        next > 0 && self.marks[next - 1].1
    }

    /// Bytes of all functions that hold at least one of the given addresses.
    pub fn code_bytes(&self, addresses: &[u64]) -> u64 {
        let mut counted_to = 0;
        let mut bytes = 0;
        for function in &self.functions {
            let entered = addresses
                .iter()
                .any(|address| function.code.contains(address));
            // Two names of one function share its addresses: count them once.
            if entered && function.code.start >= counted_to {
                bytes += function.code.end - function.code.start;
                counted_to = function.code.end;
            }
        }
        bytes
    }
}

/// What is loaded, and what lies in memory while it runs.
fn sizes(elf: &object::File<'_>) -> (u64, u64) {
    let loaded = elf.segments().map(|segment| segment.file_range().1).sum();
    let memory = elf
        .sections()
        .filter(|section| {
            matches!(
                section.kind(),
                SectionKind::Data | SectionKind::UninitializedData
            )
        })
        .map(|section| section.size())
        .sum();
    (loaded, memory)
}

/// `blx` with a register, or `bx` with any but the one a function returns by.
fn is_pointer_call(halfword: u16) -> bool {
    let register = halfword >> 3 & 15;
    halfword & 0xFF87 == 0x4780 || halfword & 0xFF87 == 0x4700 && register != 14
}

/// Target of `bl` and of the wide `b` (encodings T1 and T4 of the ARMv7-M manual), which
/// every call and every jump to another function is.
fn branch_target(address: u64, first: u16, second: u16) -> Option<u64> {
    let is_branch = first & 0xF800 == 0xF000 && matches!(second & 0xD000, 0xD000 | 0x9000);
    if !is_branch {
        return None;
    }
    let bit = |word: u16, n: u16| i64::from(word >> n & 1);
    let sign = bit(first, 10);
    let i1 = 1 - (bit(second, 13) ^ sign);
    let i2 = 1 - (bit(second, 11) ^ sign);
    let offset = -(sign << 24)
        | i1 << 23
        | i2 << 22
        | i64::from(first & 0x3FF) << 12
        | i64::from(second & 0x7FF) << 1;
    address.checked_add_signed(4 + offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decodes_calls_as_the_disassembler_does() {
        // 2666c: bl 0x4b708 and 2a: bl 0x8 of a linked image; bx lr is no branch here.
        assert_eq!(branch_target(0x2666C, 0xF025, 0xF84C), Some(0x4B708));
        assert_eq!(branch_target(0x2A, 0xF7FF, 0xFFED), Some(0x8));
        assert_eq!(branch_target(0x2A, 0xF7FF, 0xBFED), Some(0x8));
        assert_eq!(branch_target(0, 0xED9F, 0x0A00), None);
    }

    #[test]
    fn tells_a_call_through_a_register_from_a_return() {
        // blx r3, bx r2, bx lr, and an instruction of data processing.
        let found = [0x4798, 0x4710, 0x4770, 0x4618].map(is_pointer_call);
        assert_eq!(found, [true, true, false, false]);
    }

    #[test]
    fn data_between_code_is_no_call() {
        let call = [0x00, 0xF0, 0x06, 0xF8];
        let image = ArmImage {
            text: vec![(0, [call, call].concat())],
            marks: vec![(0, true), (4, false)],
            ..ArmImage::default()
        };
        assert_eq!(image.calls(&function("f", 0..8)), [0x10]);
    }

    /// A call of 0x10, where the linker's way to `far` lies.
    #[test]
    fn a_way_of_the_linker_is_seen_through() {
        let image = ArmImage {
            functions: vec![
                function("f", 0..4),
                function("__Thumbv7ABSLongThunk_far", 0x10..0x1A),
                function("far", 0x1000_0000..0x1000_0010),
            ],
            text: vec![(0, vec![0x00, 0xF0, 0x06, 0xF8])],
            marks: vec![(0, true)],
            ..ArmImage::default()
        };
        assert_eq!(image.calls(&function("f", 0..4)), [0x1000_0000]);
        let named: Vec<_> = image.named("far").map(|f| f.code.start).collect();
        assert_eq!(named, [0x1000_0000]);
    }

    fn function(name: &str, code: Range<u64>) -> Function {
        Function {
            name: name.to_owned(),
            code,
        }
    }

    #[test]
    fn counts_each_entered_function_once() {
        let image = ArmImage {
            functions: vec![
                function("a", 0..8),
                function("alias of a", 0..8),
                function("b", 8..20),
                function("c", 20..24),
            ],
            ..ArmImage::default()
        };
        assert_eq!(image.code_bytes(&[2, 4, 22]), 12);
        assert_eq!(image.code_bytes(&[]), 0);
        assert_eq!(
            image.function("b").map(|found| found.code.clone()),
            Some(8..20)
        );
    }
}
