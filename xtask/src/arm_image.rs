//! What the commands need to know of a linked image.

use std::fs;
use std::ops::Range;
use std::path::Path;

use object::{Object, ObjectSymbol, SymbolKind};

use crate::{Failure, Result};

/// A function in the image.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Function {
    /// Its name as linked.
    pub name: String,
    /// The addresses of its code.
    pub code: Range<u64>,
}

/// An image's functions, and whether it logs.
#[derive(Debug, Clone, Default)]
pub struct ArmImage {
    functions: Vec<Function>,
    has_defmt_log: bool,
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
        let has_defmt_log = elf.section_by_name(".defmt").is_some();
        Ok(Self {
            functions,
            has_defmt_log,
        })
    }

    /// Whether what it writes to stdout is a defmt log.
    pub fn has_defmt_log(&self) -> bool {
        self.has_defmt_log
    }

    /// The function of that name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|function| function.name == name)
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

#[cfg(test)]
mod tests {
    use super::*;

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
            has_defmt_log: false,
        };
        assert_eq!(image.code_bytes(&[2, 4, 22]), 12);
        assert_eq!(image.code_bytes(&[]), 0);
        assert_eq!(
            image.function("b").map(|found| found.code.clone()),
            Some(8..20)
        );
    }
}
