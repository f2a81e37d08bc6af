//! The exciter on the host: its records, responses, modes and tracks. No files and no
//! screens here, but for the record's own.

mod drive;
pub mod modes;
pub mod record;
pub mod response;
pub mod sweep;
pub mod table_3;
pub mod time;

pub use drive::{BLOCK, Commands, Drive, LOOP_HZ, RATE_HZ, Signal, needed_volts, tuning};
pub use record::{CersRecord, Setup, Truth};
