//! Telemetry and jobs: the types both ends of a link share, and their frames.

mod frame;
mod message;

pub use frame::{Deframer, FrameError, MAGIC, MAX_FRAME, VERSION, decode, encode};
pub use message::{AlarmMessage, Finished, ModeMessage, MonitorJob, Refusal, Telemetry, Verdict};
