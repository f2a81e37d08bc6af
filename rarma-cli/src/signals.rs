//! An interrupt (Ctrl-C), and being ended by the system; a browser knows neither.

use crate::failure::Failure;

/// Exit code of a program that ends at once when it is interrupted, as a shell counts it: 128 + SIGINT.
pub const INTERRUPTED: i32 = 130;

/// Who is told of an interrupt, in the order in which they asked.
#[cfg(not(target_family = "wasm"))]
static TOLD: std::sync::Mutex<Vec<Box<dyn FnMut() + Send>>> = std::sync::Mutex::new(Vec::new());

#[cfg(not(target_family = "wasm"))]
fn told() -> std::sync::MutexGuard<'static, Vec<Box<dyn FnMut() + Send>>> {
    TOLD.lock()
        .unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// Has this done when the program is to end, in place of ending it. Several may ask.
///
/// # Errors
/// The system does not let it hear of an interrupt.
#[cfg(not(target_family = "wasm"))]
pub fn on_interrupt(handle: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    let mut all = told();
    if all.is_empty() {
        let tell = || told().iter_mut().for_each(|one| one());
        ctrlc::set_handler(tell).map_err(|why| Failure::System(format!("signals: {why}")))?;
    }
    all.push(Box::new(handle));
    Ok(())
}

/// Nobody interrupts.
///
/// # Errors
/// None.
#[cfg(target_family = "wasm")]
pub fn on_interrupt(_: impl FnMut() + Send + 'static) -> Result<(), Failure> {
    Ok(())
}
