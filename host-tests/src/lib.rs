//! What the tests share: recordings, the chip's image, the real program, signals
//! of known properties, and the physical limit of an estimate.
//!
//! Nothing here is part of the product; the tests stand one file per promise in
//! `tests/`.

pub mod act_ear;
pub mod act_judge;
pub mod act_loop;
pub mod acting;
pub mod advice;
pub mod amplitude;
pub mod bars;
pub mod board_model;
pub mod bound;
pub mod cers_rig;
pub mod component;
pub mod encoder;
pub mod every_command;
pub mod exciter;
pub mod files;
pub mod flash_trials;
pub mod forced;
pub mod former_store;
pub mod frames;
pub mod grbl;
pub mod hard;
pub mod health;
pub mod hostile;
pub mod json;
pub mod ldbb;
pub mod ldbb_box;
pub mod link_bench;
#[cfg(target_os = "linux")]
pub mod linuxcnc;
pub mod modal_case;
pub mod page;
pub mod piped;
pub mod plain;
pub mod process;
pub mod refusal;
pub mod resources;
pub mod rig;
pub mod signal;
pub mod spindle_cut;
pub mod statistics;
pub mod stepping;
pub mod threshold;
pub mod watch;
