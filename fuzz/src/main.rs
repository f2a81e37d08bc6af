//! One target under libFuzzer: the one that `RARMA_FUZZ_TARGET` names. `cargo xtask fuzz`
//! builds and starts it.
#![no_main]

use cap::Cap;
use fuzz::{MEMORY_BYTES, Target, target};
use std::alloc::System;
use std::sync::OnceLock;

/// More than a case may have is refused by the allocator, which ends the program.
#[global_allocator]
static MEMORY: Cap<System> = Cap::new(System, MEMORY_BYTES);

static TARGET: OnceLock<&Target> = OnceLock::new();

/// Finds the target and writes its dictionary where libFuzzer will look for it.
fn begin() {
    let name = std::env::var("RARMA_FUZZ_TARGET").unwrap_or_default();
    let Some(found) = target(&name) else {
        panic!("RARMA_FUZZ_TARGET names no target: `{name}`");
    };
    let _ = TARGET.set(found);
    if let Some(path) = std::env::var_os("RARMA_FUZZ_DICTIONARY") {
        std::fs::write(&path, found.dictionary()).expect("the dictionary is written");
    }
}

libfuzzer_sys::fuzz_target!(init: begin(), |data: &[u8]| {
    if let Some(target) = TARGET.get() {
        (target.run)(data);
    }
});
