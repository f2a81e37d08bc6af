//! What must work when nothing else does: outputs off, and bytes that a reset leaves. Registers and memory only.

use super::{bridges, clock};
use crate::board::{Clock, Emergency};
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use embassy_stm32::pac::{DAC1, GPIOC};
use rarma_box::guard::KEPT_BYTES;

/// Pin of the power stage's enable: PC9.
pub(super) const POWER_STAGE: usize = 9;

/// What a reset leaves, and a mark that it has been written.
struct Kept(UnsafeCell<MaybeUninit<(u32, [u8; KEPT_BYTES])>>);

// SAFETY: read once at start-up, written where nothing else runs or from the main side.
unsafe impl Sync for Kept {}

#[unsafe(link_section = ".uninit.kept")]
static KEPT: Kept = Kept(UnsafeCell::new(MaybeUninit::uninit()));
const KEPT_MARK: u32 = 0x5AFE_B0C5;

/// Switches everything off: gate, switches, power stage, valve. Registers only.
pub(super) fn drop_all() {
    bridges::set_gate(false);
    bridges::open_switches();
    GPIOC.bsrr().write(|w| w.set_br(POWER_STAGE, true));
    DAC1.dhr12r(0).write(|w| w.set_dhr(0));
}

/// What a handler of a panic or an exception has of the board: registers.
#[derive(Debug)]
pub struct LastResort;

impl Clock for LastResort {
    fn now_us(&mut self) -> u64 {
        clock::now_us()
    }
}

impl Emergency for LastResort {
    fn drop_outputs(&mut self) {
        drop_all();
    }

    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]) {
        keep(bytes);
    }
}

/// What was kept, and whether the mark says that it was written.
pub(super) fn kept() -> (bool, [u8; KEPT_BYTES]) {
    // SAFETY: read at the start, when nothing else runs. After a power-up the bytes are anything, which
    // the mark and the record's own check tell; both types allow any bits.
    let (mark, kept) = unsafe {
        KEPT.0
            .get()
            .cast::<(u32, [u8; KEPT_BYTES])>()
            .read_volatile()
    };
    (mark == KEPT_MARK, kept)
}

/// Keeps bytes where a reset leaves them.
pub(super) fn keep(bytes: &[u8; KEPT_BYTES]) {
    // SAFETY: whoever calls this is the only one running: the main side, or a handler of
    // a fault, which never returns.
    unsafe {
        KEPT.0
            .get()
            .cast::<(u32, [u8; KEPT_BYTES])>()
            .write_volatile((KEPT_MARK, *bytes));
    }
}
