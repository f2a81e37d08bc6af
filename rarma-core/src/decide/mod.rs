//! Forced or self-excited, and the alarm.
//!
//! Words: *ODR*, the operational damping ratio; *undamped*, ODR below the
//! threshold with its uncertainty; *loud*, a good part of the band's power;
//! *explained*, at a multiple of the rotation or of a stronger line.

mod alarm;
mod config;
mod harmonics;
mod level;
mod mode;

pub use alarm::{Alarm, AlarmEvent, ESTABLISHED_S, Reason, Standing, State};
pub use config::AlarmConfig;
pub use harmonics::{LEAST_WIDTH_HZ, Rotation, SPEED_ACCURACY, WIDEST_FRACTION};
pub use level::{CONTRAST, CUT_RATIO, IdleFinder};
pub use mode::{Label, Mode, ModeTrack, Reading};
