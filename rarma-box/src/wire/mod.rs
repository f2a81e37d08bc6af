//! Telemetry and jobs: the types both ends of a link share, and their frames.

mod circle;
mod command;
mod excitation;
mod frame;
mod message;
mod speaker;
mod window;

pub use crate::key::{KEY_BYTES, LinkKey, SEAL_BYTES, Seal};
pub use circle::{
    CIRCLE_POINTS, CIRCLE_RATE_HZ, CircleJob, CircleMessage, CirclePoints, JOB_PRESSURES, PAUSE_S,
    StandJob,
};
pub use command::{
    Answer, Command, ControlMessage, FaultMessage, Handed, Health, Identity, NOBODY, Order,
    RAW_SAMPLES, Raw, Refused, Reply, SettingMessage, Started, Status,
};
pub use excitation::{EndMessage, ExcitationMessage, LineMessage};
pub use frame::{
    Deframer, FrameError, Head, MAGIC, MAX_FRAME, NO_SESSION, Opened, VERSION, decode, encode,
    encode_order, head, open,
};
pub use message::{
    AlarmMessage, AmplitudeMessage, Finished, HistogramMessage, ModeMessage, MonitorJob, Notice,
    NoticeMessage, Refusal, SpindleMessage, Telemetry, Verdict,
};
pub use speaker::Speaker;
pub use window::{Arrival, WINDOW, Window};
