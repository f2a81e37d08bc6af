//! A real controller of a machine.

use crate::Result;
use crate::process;
use crate::toolchain::packages;

/// What Debian calls LinuxCNC, and its program.
const PACKAGE: &str = "linuxcnc-uspace";
const PROGRAM: &str = "linuxcnc";

/// Installs LinuxCNC where it is not here.
///
/// # Errors
/// It cannot be had.
pub(crate) fn linuxcnc() -> Result<()> {
    match process::find_program(PROGRAM) {
        Some(_) => Ok(()),
        None => packages::install(&[PACKAGE]),
    }
}
