//! How the program is read: from the flash, and what must not wait for it from the memory coupled to the
//! core. The brown-out level of the option bytes.

use cortex_m::peripheral::MPU;
use embassy_stm32::pac::FLASH;

/// Voltages of the levels of BOR_LEV, falling, mV (RM0440, option register of the flash).
const BROWN_OUT_MV: [u16; 5] = [1700, 2000, 2200, 2500, 2800];

/// Prefetch on: while one double word of program is executed the next one is fetched. The caches
/// are on after a reset, prefetch is not, and the HAL leaves it so. ST's sheet for the STM32G0B1
/// (ES0548, 2.2.10) forbids prefetch across the two banks of that chip; it is another core and
/// another flash interface, and systems that heed it there (Zephyr) use prefetch on every G4.
pub(super) fn start() {
    FLASH.acr().modify(|w| w.set_prften(true));
}

unsafe extern "C" {
    // By the linker (memory/nucleo-g474re.x): where it lies in the flash, where it runs.
    static _coupled_from: u32;
    static mut _coupled_start: u32;
    static mut _coupled_end: u32;
}

/// CCM SRAM: where the core fetches from it, and where the stack lies in it.
const COUPLED: [u32; 2] = [0x1000_0000, 0x2001_8000];
/// It is protected in eight parts.
const PART_BYTES: usize = 4096;
/// Fields of MPU_RASR (ARMv7-M, B3.5.9): never execute; read only; cached, as SRAM is; 32 KiB; on.
const NEVER_EXECUTE: u32 = 1 << 28;
const READ_ONLY: u32 = 0b110 << 24;
const CACHED: u32 = 1 << 17;
const KIB_32: u32 = 14 << 1;
const ON: u32 = 1;
/// MPU_RBAR: the number of the region is with the address. MPU_CTRL: what no region covers is as without.
const VALID: u32 = 1 << 4;
const ELSE_AS_BEFORE: u32 = 1 << 2;

/// Puts the program that must not wait where the core fetches it at once, and keeps the stack, which has
/// gone there until now, out of it.
pub(super) fn copy_program() {
    let (from, to) = (&raw const _coupled_from, &raw mut _coupled_start);
    let bytes = (&raw const _coupled_end).addr() - to.addr();
    let free_parts = 0xFF_u32 << bytes.div_ceil(PART_BYTES) & 0xFF;
    // SAFETY: the linker has kept both places for that, whole words of them, apart from each other;
    // nothing there runs before, and the stack ends above it by now (xtask/src/chip/figures.rs).
    unsafe { core::ptr::copy_nonoverlapping(from, to, bytes / size_of::<u32>()) };
    // SAFETY: nothing else here uses the unit.
    let mpu = unsafe { &*MPU::PTR };
    for ((region, at), fetches) in (0..).zip(COUPLED).zip([0, NEVER_EXECUTE]) {
        let rights = fetches | READ_ONLY | CACHED;
        // SAFETY: nothing writes there from here on, but a stack that has grown too far.
        unsafe {
            mpu.rbar.write(at | VALID | region);
            mpu.rasr.write(rights | free_parts << 8 | KIB_32 | ON);
        }
    }
    // SAFETY: as above.
    unsafe { mpu.ctrl.write(ELSE_AS_BEFORE | ON) };
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Voltage below which the brown-out reset comes, mV.
pub(super) fn brown_out_mv() -> u16 {
    let level = usize::from(FLASH.optr().read().bor_lev());
    // The other three levels are reserved.
    BROWN_OUT_MV.get(level).copied().unwrap_or(0)
}
