//! Commands that build, run, count and check the workspace.
//!
//! `cargo` aliases call the binary; each command is one module with a `main` that
//! takes the arguments after its name and returns the process' exit code.

pub mod arm_image;
pub mod board;
pub mod book;
pub mod chip;
pub mod count;
pub mod demo;
pub mod failure;
pub mod fuzz;
pub mod fw;
pub mod gallery;
pub mod inputs;
pub mod long;
mod needs;
pub mod page;
pub mod pico;
pub mod process;
mod python_environment;
pub mod qemu;
pub mod rooms;
pub mod screens;
mod side_by_side;
pub mod sound;
pub mod tmux;
pub mod toolchain;
pub mod verify;
pub mod web;
pub mod workspace;

pub use failure::{Failure, Result};
pub use workspace::Workspace;

/// The Rust target of most boards: Cortex-M4 with a single-precision FPU.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The board that is emulated whole, and the default of every command.
pub const EMULATED_BOARD: &str = "mps2-an386";

/// The board whose emulated core is a Cortex-M33: what is counted and tested there.
pub const EMULATED_M33: &str = "mps2-an505";

/// The image of the whole box on that board, whose link is a serial port.
pub const EMULATED_BOX: &str = "mps2-an386-box";
