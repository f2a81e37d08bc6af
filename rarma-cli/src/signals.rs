//! An interrupt (Ctrl-C), and being ended by the system; a browser knows neither.

use crate::failure::Failure;

/// Has this done when the program is to end, in place of ending it.
///
/// # Errors
/// The system does not let it hear of an interrupt, or somebody else hears of it already.
#[cfg(not(target_family = "wasm"))]
pub fn on_interrupt(handle: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    ctrlc::set_handler(handle).map_err(|why| Failure::System(format!("signals: {why}")))
}

/// Nobody interrupts.
///
/// # Errors
/// None.
#[cfg(target_family = "wasm")]
pub fn on_interrupt(_: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    Ok(())
}
