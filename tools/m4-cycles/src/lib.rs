//! QEMU TCG plugin: executed instructions between two addresses, by class, with an
//! estimate of the cycles a Cortex-M4F needs for them.
//!
//! Load it with `-plugin libm4_cycles.so,begin=ADDRESS,end=ADDRESS,out=FILE`
//! (addresses in hexadecimal). Counting is on from the instruction at `begin` to the
//! one at `end`, each time they are executed. The report is written when QEMU ends.
//!
//! The instruction count is exact and repeats. The cycles are an estimate: zero wait
//! states, ARM's timing table (see [`timing`]), never compared with hardware.

pub mod arguments;
pub mod disassembly;
pub mod report;
pub mod timing;
pub mod trace;

// Everything that needs QEMU's symbols; absent in the unit tests, which have no QEMU.
#[cfg(not(test))]
mod plugin;
