//! Forced or self-excited, and the alarm.
//!
//! Words: *ODR*, the operational damping ratio; *undamped*, ODR below the
//! threshold with its uncertainty; *loud*, a good part of the band's power;
//! *explained*, at a multiple of the rotation or of a stronger line.

mod alarm;
mod background;
mod config;
mod fpk;
mod fpk_histogram;
mod fpk_verdict;
mod harmonics;
mod level;
mod mode;
mod origin;
mod places;
mod sequential;

pub use alarm::{Alarm, AlarmEvent, ESTABLISHED_S, Reason, Standing, State};
pub use background::{Background, GROWN, Tone};
pub use config::AlarmConfig;
pub use fpk::{Fpk, LEAST_DAMPING, MEMORY_S};
pub use fpk_histogram::{BINS, BINS_REACH, DecreasingFit, Histogram};
pub use fpk_verdict::{
    Amplitude, AmplitudeReading, LEAST_EFFECTIVE, LIMIT_SCINTILLATION, SUSPICIOUS_SCINTILLATION,
    critical_scintillation,
};
pub use harmonics::{
    HIGHEST_FLIP_HALVES, LEAST_WIDTH_HZ, Rotation, SPEED_ACCURACY, WIDEST_FRACTION,
};
pub use level::{CONTRAST, CUT_RATIO, IdleFinder};
pub use mode::{Label, Mode, ModeTrack, Reading};
pub use origin::Origin;
pub use places::Places;
pub use sequential::{
    DAMPED_RATIO, ENOUGH, ENOUGH_BACK, Evidence, LEAST_USUAL_RATIO, SequentialTest, UNDAMPED_RATIO,
    USUAL_RATIO,
};
