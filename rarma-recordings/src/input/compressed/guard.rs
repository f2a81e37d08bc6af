//! A decoder of others may have a defect that a broken file finds. It is safe Rust: what
//! comes of it is a panic, which is caught here and said in one line like any broken file.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// This thread is inside [`caught`].
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Told once, whatever threads are reading.
static SILENCED: Once = Once::new();

/// What `work` gives; none if it panicked, which is not told on standard error.
pub(super) fn caught<T>(work: impl FnOnce() -> T) -> Option<T> {
    SILENCED.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if !INSIDE.get() {
                before(info);
            }
        }));
    });
    let outer = INSIDE.replace(true);
    // What is left behind half done is not used again but to be dropped or asked again.
    let done = panic::catch_unwind(AssertUnwindSafe(work));
    INSIDE.set(outer);
    done.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_value() {
        assert_eq!(caught(|| 3), Some(3));
        let nothing: [u8; 0] = [];
        let far = nothing.len() + 1;
        assert_eq!(caught(|| nothing[far]), None);
        assert!(!INSIDE.get());
    }
}
