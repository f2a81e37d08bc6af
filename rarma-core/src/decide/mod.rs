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

pub use agreement::{
    AGREE_LEAST, AGREE_MOST, AGREE_SDS, Agreement, JOINT_SUSPICION, jointly_suspicious, partner,
    same_mode, surer, unexplained,
};
pub use alarm::{Alarm, AlarmEvent, AlarmInForce, Callers, ESTABLISHED_S, Reason, State};
pub use channels::{
    CONTRADICTION_S, CONTRADICTION_SDS, ChannelFault, ChannelWatch, Dropped, Hearing, MOVED_RATIO,
    SILENT_RATIO, STILL_RATIO, TAKEN_BACK_S,
};
pub use config::AlarmConfig;
pub use fpk::{Fpk, LEAST_DAMPING, MEMORY_S};
pub use fpk_histogram::{BINS, BINS_REACH, DecreasingFit, Histogram};
pub use fpk_verdict::{
    Amplitude, AmplitudeReading, LEAST_EFFECTIVE, LIMIT_SCINTILLATION, SUSPICIOUS_SCINTILLATION,
    critical_scintillation,
};
pub use harmonics::{LEAST_WIDTH_HZ, Rotation, SPEED_ACCURACY, WIDEST_FRACTION};
pub use level::{CONTRAST, CUT_RATIO, IdleFinder};
pub use mode::{Label, Mode, ModeTrack, Reading, SAME_MODE};
pub use onset::Onset;
pub use origin::Origin;
pub use places::{Places, Sight};
pub use runaway::Runaway;
pub use sequential::{
    DAMPED_RATIO, ENOUGH, ENOUGH_BACK, Evidence, LEAST_USUAL_RATIO, SequentialTest, UNDAMPED_RATIO,
    USUAL_RATIO,
};
pub use steady::Steadiness;
pub use structure::{
    MAX_STRUCTURAL_MODES, ProcessDamping, STRUCTURE_SDS, STRUCTURE_WIDTH, StructuralMode,
    Structure, StructureError,
};
