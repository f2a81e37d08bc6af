//! The stack that an image may need, read from its code: what every function takes at once, along every
//! way that calls can go.
//!
//! A function takes what its instructions push and subtract, added up, taken or not. Where it calls
//! through a pointer, it may call any function whose address lies in the image as a word. Ways that come back to where they were are counted once, and told.

use std::collections::BTreeMap;

use crate::arm_image::{ArmImage, Function};
use crate::{Failure, Result};

/// What an exception's entry takes with floating point in use, and to be a whole number of 8 bytes.
const FRAME_BYTES: u64 = 104 + 4;

/// The deepest way from a function, in bytes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Deepest {
    /// Bytes.
    pub bytes: u64,
    /// The functions on that way, each with what it takes.
    pub way: Vec<(String, u64)>,
}

impl Deepest {
    /// The functions that take most of it.
    fn told(&self) -> String {
        let large = self.way.iter().filter(|(_, bytes)| *bytes >= 200);
        let each = large.map(|(name, bytes)| format!("{name} {bytes}"));
        let all: Vec<_> = each.collect();
        format!("{} bytes; {}", self.bytes, all.join(", "))
    }
}

/// The stack of an image's functions.
#[derive(Debug)]
pub struct Stack<'a> {
    image: &'a ArmImage,
    /// Where pointers may lead.
    pointed: Vec<u64>,
    /// Parts of the names of functions that are over by then.
    over: Vec<&'a str>,
    known: BTreeMap<u64, Deepest>,
    under_way: Vec<u64>,
    /// Functions that can come back to themselves.
    pub recursive: Vec<String>,
    /// Functions that take what is not known: a register's worth.
    pub unknown: Vec<String>,
}

impl<'a> Stack<'a> {
    /// Of an image. Any word of it that is a function's address is one that a pointer may hold.
    pub fn new(image: &'a ArmImage, words: impl IntoIterator<Item = u32>) -> Self {
        let odd = words.into_iter().filter(|word| word & 1 == 1);
        let mut pointed: Vec<u64> = odd.map(|word| u64::from(word - 1)).collect();
        pointed.sort_unstable();
        pointed.dedup();
        pointed.retain(|&at| image.at(at).next().is_some());
        Self {
            image,
            pointed,
            over: Vec::new(),
            known: BTreeMap::new(),
            under_way: Vec::new(),
            recursive: Vec::new(),
            unknown: Vec::new(),
        }
    }

    /// The same, when functions with one of these parts in their names have returned and are not called
    /// again.
    #[must_use]
    pub fn after(mut self, over: &[&'a str]) -> Self {
        self.over = over.to_vec();
        self
    }

    /// The deepest a program can go: the main program, an interrupt's handler in it, and the exception
    /// that cannot be masked in that one.
    ///
    /// # Errors
    /// A function takes what is not known, or there is no main program.
    pub fn program(&mut self, handlers: &[&str]) -> Result<u64> {
        let image = self.image;
        let mut of = |name: &str| {
            let function = image.function(name)?;
            Some(self.deepest(function))
        };
        let main = of("Reset").ok_or_else(|| Failure::new("the image has no function `Reset`"))?;
        let none = Deepest::default;
        let handler = handlers.iter().filter_map(|name| of(name));
        let handler = handler.max_by_key(|way| way.bytes).unwrap_or_else(none);
        let last = of("NonMaskableInt").unwrap_or_else(none);
        for (what, way) in [
            ("main program", &main),
            ("handler", &handler),
            ("last", &last),
        ] {
            eprintln!("chip: stack of the {what}: {}", way.told());
        }
        if let Some(name) = self.unknown.first() {
            return Err(Failure::new(format!(
                "the stack cannot be read from the code: {name} takes as much as a register says"
            )));
        }
        Ok(main.bytes + handler.bytes + last.bytes + 2 * FRAME_BYTES)
    }

    /// The deepest way from a function.
    pub fn deepest(&mut self, function: &Function) -> Deepest {
        let start = function.code.start;
        if let Some(known) = self.known.get(&start) {
            return known.clone();
        }
        if self.under_way.contains(&start) {
            self.recursive.push(function.name.clone());
            return Deepest::default();
        }
        let is_over = self.over.iter().any(|part| function.name.contains(part));
        if is_over {
            return Deepest::default();
        }
        self.under_way.push(start);
        let own = self.frame(function);
        let mut targets = self.image.calls(function);
        if self.image.pointer_calls(function) > 0 {
            targets.extend(&self.pointed);
        }
        targets.sort_unstable();
        targets.dedup();
        let mut below = Deepest::default();
        for target in targets {
            let image = self.image;
            if let Some(callee) = image.at(target).next() {
                let found = self.deepest(callee);
                if found.bytes > below.bytes {
                    below = found;
                }
            }
        }
        self.under_way.pop();
        let mut way = vec![(function.name.clone(), own)];
        way.append(&mut below.way);
        let found = Deepest {
            bytes: own + below.bytes,
            way,
        };
        self.known.insert(start, found.clone());
        found
    }

    /// What a function takes at the most.
    fn frame(&mut self, function: &Function) -> u64 {
        let instructions = self.image.instructions(function);
        let mut bytes = 0;
        for &(_, first, second) in &instructions {
            match taken(first, second) {
                Some(more) => bytes += more,
                None => self.unknown.push(function.name.clone()),
            }
        }
        bytes
    }
}

/// What an instruction takes of the stack: pushes, and subtractions from its pointer. None where it is
/// a register's worth.
fn taken(first: u16, second: u16) -> Option<u64> {
    let registers = |list: u16| 4 * u64::from(list.count_ones());
    let i = u64::from(first >> 10 & 1);
    let imm12 = i << 11 | u64::from(second >> 12 & 7) << 8 | u64::from(second & 0xFF);
    let to_sp = second >> 8 & 15 == 13;
    Some(match first {
        // push, narrow and wide
        0xB400..=0xB5FF => registers(first & 0x1FF),
        0xE92D => registers(second),
        // str rX, [sp, #-n]!
        0xF84D if second & 0x0F00 == 0x0D00 => u64::from(second & 0xFF),
        // vpush
        0xED2D | 0xED6D => 4 * u64::from(second & 0xFF),
        // sub sp, #n, then wide with both kinds of a constant
        0xB080..=0xB0FF => 4 * u64::from(first & 0x7F),
        0xF1AD | 0xF5AD | 0xF1BD | 0xF5BD if to_sp => modified(imm12),
        0xF2AD | 0xF6AD if to_sp => imm12,
        // sub sp, sp, rX
        0xEBAD if to_sp => return None,
        _ => 0,
    })
}

/// A modified constant of the architecture's manual (A5.3.2).
fn modified(imm12: u64) -> u64 {
    let byte = imm12 & 0xFF;
    match imm12 >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => u64::from(((0x80 | byte & 0x7F) as u32).rotate_right((imm12 >> 7) as u32)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words as a disassembler shows them.
    #[test]
    fn pushes_and_subtractions_are_read() {
        for (first, second, bytes) in [
            (0xB5F0, 0, Some(20)),        // push {r4-r7, lr}
            (0xE92D, 0x4FF0, Some(36)),   // push.w {r4-r11, lr}
            (0xF84D, 0x8D04, Some(4)),    // str.w r8, [sp, #-4]!
            (0xED2D, 0x8B10, Some(64)),   // vpush {d8-d15}
            (0xB086, 0, Some(24)),        // sub sp, #24
            (0xF5AD, 0x7D2A, Some(680)),  // sub.w sp, sp, #680
            (0xF2AD, 0x4D7C, Some(1148)), // subw sp, sp, #1148
            (0xEBAD, 0x0D03, None),       // sub.w sp, sp, r3
            (0xB006, 0, Some(0)),         // add sp, #24
            (0xF5A0, 0x702A, Some(0)),    // sub.w r0, r0, #680
        ] {
            assert_eq!(taken(first, second), bytes, "{first:#x} {second:#x}");
        }
    }
}
