//! The image for the Raspberry Pi Pico 2: whether the ROM of its RP2350 would start it, and the file by which
//! it is flashed with nothing but a file manager.
//!
//! The rules are those of the data sheet's chapter on the boot ROM: a block stands in the first 4 KB, between
//! two markers, and says in items what the image is; blocks form a loop by their links.

use std::fs;
use std::path::{Path, PathBuf};

use object::{Object, ObjectSegment};

use crate::{Failure, Result};

/// The board.
pub const BOARD: &str = "pico2";

/// Where the flash begins.
const FLASH: u64 = 0x1000_0000;
/// Where the RAM begins, and its bytes.
const RAM: u32 = 0x2000_0000;
const RAM_BYTES: u32 = 520 << 10;
/// The ROM looks for a block so far.
const SEARCHED: usize = 4096;
const BLOCK_START: u32 = 0xFFFF_DED3;
const BLOCK_END: u32 = 0xAB12_3579;
/// First bytes of items: what the image is; the last one.
const IMAGE_TYPE: u8 = 0x42;
const LAST: u8 = 0xFF;
/// An executable (1), for ARM in secure state (2), on the RP2350 (1), bought already.
const ARM_SECURE_EXECUTABLE: u16 = 0x1021;

/// What an image holds of the flash, from its beginning.
///
/// # Errors
/// When the file is no ELF, or loads something elsewhere.
pub fn flash_of(elf: &Path) -> Result<Vec<u8>> {
    let failed = |why: String| {
        Failure::new(format!("{} is no image for a Pico 2", elf.display())).because(why)
    };
    let bytes = fs::read(elf).map_err(|why| failed(why.to_string()))?;
    let file = object::File::parse(&*bytes).map_err(|why| failed(why.to_string()))?;
    let object::File::Elf32(file) = &file else {
        return Err(failed("it is not for a processor of 32 bits".to_owned()));
    };
    let mut flash = Vec::new();
    for segment in file.segments() {
        let data = segment.data().map_err(|why| failed(why.to_string()))?;
        if data.is_empty() {
            continue;
        }
        // Where it is loaded to, which is not where it is used.
        let endian = file.endian();
        let physical = segment.elf_program_header().p_paddr.get(endian);
        let at = u64::from(physical)
            .checked_sub(FLASH)
            .and_then(|at| usize::try_from(at).ok())
            .ok_or_else(|| failed(format!("it loads something at {physical:#x}")))?;
        let end = at + data.len();
        if flash.len() < end {
            flash.resize(end, 0xFF);
        }
        flash[at..end].copy_from_slice(data);
    }
    Ok(flash)
}

fn word(flash: &[u8], at: usize) -> std::result::Result<u32, String> {
    let bytes = flash.get(at..at + 4).ok_or("the image ends too early")?;
    Ok(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]))
}

/// Whether the ROM would start what is in the flash; says where its block is.
///
/// # Errors
/// Names the rule that is broken.
pub fn check(flash: &[u8]) -> std::result::Result<usize, String> {
    let searched = &flash[..flash.len().min(SEARCHED)];
    let at = (0..searched.len())
        .step_by(4)
        .find(|at| word(searched, *at) == Ok(BLOCK_START))
        .ok_or("there is no block in the first 4 KB")?;
    let mut item = at + 4;
    let mut kind = None;
    loop {
        let head = word(flash, item)?;
        let [code, size, low, high] = head.to_le_bytes();
        let half = u16::from_le_bytes([low, high]);
        match code {
            LAST => {
                // Its size, of two bytes, is that of the items before it.
                let items = usize::from(u16::from_le_bytes([size, low]));
                if items * 4 != item - at - 4 {
                    return Err(format!("the last item says {items} words of items"));
                }
                break;
            }
            IMAGE_TYPE => kind = Some(half),
            other => return Err(format!("item {other:#x} is not known here")),
        }
        if size == 0 {
            return Err("an item has no length".to_owned());
        }
        item += 4 * usize::from(size);
    }
    match kind {
        Some(ARM_SECURE_EXECUTABLE) => {}
        Some(other) => return Err(format!("the image's type is {other:#06x}")),
        None => return Err("the block does not say what the image is".to_owned()),
    }
    let link = word(flash, item + 4)?;
    if link != 0 {
        return Err(format!("the only block links to {link:#x}, not to itself"));
    }
    if word(flash, item + 8)? != BLOCK_END {
        return Err("the block does not end with its marker".to_owned());
    }
    // Without an item that says otherwise the vectors are at the beginning.
    let (stack, reset) = (word(flash, 0)?, word(flash, 4)?);
    if !(RAM + 8..=RAM + RAM_BYTES).contains(&stack) || !stack.is_multiple_of(8) {
        return Err(format!("the stack begins at {stack:#x}"));
    }
    let inside = FLASH..FLASH + flash.len() as u64;
    if reset & 1 == 0 || !inside.contains(&u64::from(reset)) {
        return Err(format!("the first instruction is at {reset:#x}"));
    }
    Ok(at)
}

/// Numbers of the format UF2 (its specification): three magic ones, the flag that a family is named, and the
/// family of the RP2350 for ARM in secure state.
const UF2_MAGIC: [u32; 2] = [0x0A32_4655, 0x9E5D_5157];
const UF2_END: u32 = 0x0AB1_6F30;
const UF2_FAMILY_NAMED: u32 = 0x2000;
const RP2350_ARM_S: u32 = 0xE48B_FF59;
/// Bytes of flash in a block of 512: a page.
const UF2_PAGE: usize = 256;

/// The flash as a file that the ROM takes when it shows itself as a disk.
#[must_use]
pub fn uf2(flash: &[u8]) -> Vec<u8> {
    let pages = flash.chunks(UF2_PAGE);
    let count = pages.len() as u32;
    let mut file = Vec::with_capacity(pages.len() * 512);
    for (number, page) in (0..).zip(pages) {
        let mut block = [0u8; 512];
        let address = FLASH as u32 + number * UF2_PAGE as u32;
        let head = [
            UF2_MAGIC[0],
            UF2_MAGIC[1],
            UF2_FAMILY_NAMED,
            address,
            UF2_PAGE as u32,
            number,
            count,
            RP2350_ARM_S,
        ];
        for (place, value) in block.chunks_mut(4).zip(head) {
            place.copy_from_slice(&value.to_le_bytes());
        }
        block[32..32 + UF2_PAGE].fill(0xFF);
        block[32..32 + page.len()].copy_from_slice(page);
        block[508..].copy_from_slice(&UF2_END.to_le_bytes());
        file.extend(block);
    }
    file
}

/// Checks a linked image and lays the file to flash it with beside it, whose path is returned.
///
/// # Errors
/// When the ROM would not start it, or the file cannot be written.
pub fn finish(elf: &Path) -> Result<PathBuf> {
    let flash = flash_of(elf)?;
    check(&flash).map_err(|why| {
        Failure::new(format!("the ROM would not start {}", elf.display())).because(why)
    })?;
    let path = elf.with_extension("uf2");
    fs::write(&path, uf2(&flash))
        .map_err(|why| Failure::new(format!("cannot write {}", path.display())).because(why))?;
    Ok(path)
}

#[cfg(test)]
#[path = "pico_test.rs"]
mod tests;
