//! Telemetry and jobs: the types both ends of a link share, and their frames.

mod frame;
mod message;

pub use frame::{Deframer, FrameError, MAGIC, MAX_FRAME, VERSION, decode, encode};
pub use message::{
    AlarmMessage, AmplitudeMessage, Finished, HistogramMessage, ModeMessage, MonitorJob, Notice,
    NoticeMessage, Refusal, SpindleMessage, Telemetry, Verdict,
};
