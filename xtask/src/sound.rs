//! Programs and libraries that tests of sound need.

use crate::toolchain::packages;
use crate::{Failure, Result, process};

/// The encoder that most people have.
const ENCODER: &str = "ffmpeg";

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
