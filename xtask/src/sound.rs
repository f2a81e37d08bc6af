//! Programs and libraries that tests of sound need.

use std::process::Command;

use crate::toolchain::packages;
use crate::{Failure, Result, process};

/// The encoder that most people have.
const ENCODER: &str = "ffmpeg";

/// What a program that listens to sound cards is built with: the system's library for sound, and what
/// finds it.
const CARD_PACKAGES: [&str; 2] = ["libasound2-dev", "pkg-config"];

/// Makes sure that programs for sound cards can be built.
///
/// # Errors
/// The system's library for sound is not here, and may not be installed.
pub fn ensure_card_library() -> Result<()> {
    let mut asked = Command::new("pkg-config");
    asked.args(["--exists", "alsa"]);
    if process::output(&mut asked).is_ok() {
        return Ok(());
    }
    packages::install(&CARD_PACKAGES).map_err(|failure| {
        Failure::new("no library for sound cards (ALSA) to build with")
            .because(&failure)
            .advise("install it with your package manager; only `rarma listen` needs it")
    })
}

/// Makes sure that there is an encoder of sound.
///
/// # Errors
/// There is none, and it may not be installed here.
pub fn ensure_encoder() -> Result<()> {
    if process::find_program(ENCODER).is_some() {
        return Ok(());
    }
    packages::install(&[ENCODER]).map_err(|failure| {
        Failure::new(format!("no {ENCODER} on this machine"))
            .because(&failure)
            .advise("install it with your package manager; the rest works without it")
    })
}
