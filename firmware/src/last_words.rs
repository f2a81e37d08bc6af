//! What a panic or an exception does: outputs first, then the record, then nothing.

use crate::board::Emergency;
use rarma_box::guard::{FaultCode, FaultRecord};

/// Drops the outputs, then keeps the fault for the host to read after the reset. A board's
/// panic and exception handlers call this first, log after it, and then reset.
///
/// `value` is whatever the handler knows (a line number, a status word).
#[inline(never)]
pub fn last_words<E: Emergency>(board: &mut E, code: FaultCode, value: f32) {
    board.drop_outputs();
    let record = FaultRecord {
        code,
        place: 0,
        value,
        at_us: board.now_us(),
    };
    board.keep(&record.to_kept());
}
