//! Forced or self-excited, and the alarm.
//!
//! Words: *ODR*, the operational damping ratio; *undamped*, ODR below the
//! threshold with its uncertainty; *loud*, a good part of the band's power;
//! *explained*, at a multiple of the rotation or of a stronger line.

mod agreement;
mod alarm;
mod channels;
mod config;
mod fpk;
mod fpk_histogram;
mod fpk_verdict;
mod harmonics;
mod level;
mod mode;
mod onset;
mod origin;
mod places;
mod runaway;
mod sequential;
mod steady;
mod structure;

pub use agreement::Agreement;
pub use alarm::{AlarmEvent, Reason, State};
pub use channels::{ChannelFault, Dropped, MOVED_RATIO, SILENT_RATIO};
pub use config::AlarmConfig;
pub use fpk::{Fpk, LEAST_DAMPING, MEMORY_S};
pub use fpk_histogram::{BINS, BINS_REACH, DecreasingFit, Histogram};
pub use fpk_verdict::{
    Amplitude, AmplitudeReading, LIMIT_SCINTILLATION, SUSPICIOUS_SCINTILLATION,
    critical_scintillation,
};
pub use mode::{Label, Mode};
pub use origin::Origin;
pub use sequential::{DAMPED_RATIO, Evidence};
pub use structure::{
    MAX_STRUCTURAL_MODES, ProcessDamping, STRUCTURE_SDS, STRUCTURE_WIDTH, StructuralMode,
    Structure, StructureError,
};

// What the monitor is made of.
pub(crate) use agreement::{jointly_suspicious, partner, surer};
pub(crate) use alarm::{Alarm, Callers};
pub(crate) use channels::{ChannelWatch, Hearing};
pub(crate) use harmonics::{Rotation, SPEED_ACCURACY};
pub(crate) use level::{CUT_RATIO, IdleFinder};
pub(crate) use mode::{ModeTrack, Reading, SAME_MODE};
pub(crate) use onset::Onset;
pub(crate) use places::{Places, Sight};
pub(crate) use runaway::Runaway;
pub(crate) use sequential::SequentialTest;
pub(crate) use steady::Steadiness;
