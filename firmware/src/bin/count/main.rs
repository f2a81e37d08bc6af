//! Kernels to count: `cargo xtask count` runs each over the same signal and counts the
//! instructions between `roi_begin` and `roi_end`.
//!
//! The semihosting command line is `--list` (answer: `kernel NAME` lines) or a kernel's
//! name (answer: `samples N state_bytes X stack_bytes Y`). Every kernel is warmed up first,
//! so that what is counted is the steady state. To add a kernel, implement
//! `Kernel` and name it in `kernels!`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this image counts instructions on the target: cargo xtask count");
}

#[cfg(target_os = "none")]
mod target;
