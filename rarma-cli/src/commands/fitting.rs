//! What fits of several commands share: a thread with room, the criteria, what to do where there are none.

use rarma_fit::{Criteria, FitError};

/// The largest models keep their arrays on the stack.
const STACK_BYTES: usize = 64 << 20;

/// Runs a fit on a thread with room for the largest models.
pub(super) fn with_stack<V: Send>(
    fit: impl FnOnce() -> Result<V, String> + Send,
) -> Result<V, String> {
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, fit)
            .map_err(|why| format!("no thread for the fit: {why}"))?
            .join()
            .map_err(|_| "the fit broke off: a defect of this program".to_owned())?
    })
}

/// What to do where a model cannot be fitted.
pub(super) const REMEDY: &str = "(choose another --order or --method, or record longer)";

/// The criteria, or why there are none.
pub(super) fn criteria(sigma2: f64, n: usize, k: usize) -> Result<Criteria<f64>, String> {
    Criteria::of(sigma2, n, k).map_err(|why| match why {
        FitError::OutOfRange if sigma2 == 0.0 => {
            "nothing is left over: each sample follows from those before it (choose a lower --order)".to_owned()
        }
        FitError::OutOfRange => format!(
            "what is left over grows without bound: C has a root outside the unit circle {REMEDY}"
        ),
        why => format!("{why} {REMEDY}"),
    })
}
