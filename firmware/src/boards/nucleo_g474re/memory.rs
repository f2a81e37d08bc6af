//! How the program is read: from the flash, and what must not wait for it from the memory coupled to the
//! core. The brown-out level of the option bytes.

use embassy_stm32::pac::FLASH;

/// Voltages of the levels of BOR_LEV, falling, mV (RM0440, option register of the flash).
const BROWN_OUT_MV: [u16; 5] = [1700, 2000, 2200, 2500, 2800];

/// Prefetch on: while one double word of program is executed the next one is fetched. The caches
/// are on after a reset, prefetch is not, and the HAL leaves it so. ST's sheet for the STM32G0B1
/// (ES0548, 2.2.10) forbids prefetch across the two banks of that chip; it is another core and
/// another flash interface, and systems that heed it there (Zephyr) use prefetch on every G4.
pub(super) fn start() {
    FLASH.acr().modify(|w| w.set_prften(true));
    copy_program();
}

unsafe extern "C" {
    // By the linker (memory/nucleo-g474re.x): where it lies in the flash, where it runs.
    static _coupled_from: u32;
    static mut _coupled_start: u32;
    static mut _coupled_end: u32;
}

/// Puts the current loop's program where the core fetches it without waiting.
fn copy_program() {
    let (from, to) = (&raw const _coupled_from, &raw mut _coupled_start);
    let bytes = (&raw const _coupled_end).addr() - to.addr();
    // SAFETY: the linker has kept both places for that, whole words of them, apart from each other;
    // nothing there runs before, the loop is started later.
    unsafe { core::ptr::copy_nonoverlapping(from, to, bytes / size_of::<u32>()) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Voltage below which the brown-out reset comes, mV.
pub(super) fn brown_out_mv() -> u16 {
    let level = usize::from(FLASH.optr().read().bor_lev());
    // The other three levels are reserved.
    BROWN_OUT_MV.get(level).copied().unwrap_or(0)
}
