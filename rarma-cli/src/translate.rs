//! The words of the wire in the words of the records.

use crate::record::{
    AmplitudeRecord, AmplitudeVerdict, Label, Line, ModeRecord, NoticeKind, Origin, Reason,
    SpeedSource, SpindleRecord, State, TachoFault,
};
use rarma_box::wire::{AmplitudeMessage, ModeMessage, Notice, SpindleMessage, Verdict};
use rarma_core::{condition, decide, monitor};

/// States in the order of [`decide::State`].
pub(crate) const STATES: [State; 6] = [
    State::Starting,
    State::Idle,
    State::Stable,
    State::Warning,
    State::Chatter,
    State::Invalid,
];

/// A verdict as a line.
pub(crate) fn line(verdict: &Verdict, fs: f64) -> Line {
    Line {
        t: verdict.sample as f64 / fs,
        state: STATES[verdict.state as usize],
        reason: reason(verdict.reason),
        modes: verdict.modes.iter().map(mode).collect(),
        spindle: spindle(&verdict.spindle),
        amplitude: verdict.amplitude.as_ref().map(amplitude),
        agreement: None,
    }
}

/// A notice; speeds in 1/min.
pub(crate) fn notice(notice: &Notice) -> NoticeKind {
    match *notice {
        Notice::Contradiction { told_hz, found_hz } => NoticeKind::Contradiction {
            told_rpm: rpm(told_hz),
            found_rpm: rpm(found_hz),
        },
        Notice::Tacho(fault) => NoticeKind::Tacho {
            fault: match fault {
                condition::TachoFault::Silent => TachoFault::Silent,
                condition::TachoFault::Missing => TachoFault::Missing,
                condition::TachoFault::Doubled => TachoFault::Doubled,
                condition::TachoFault::Noisy => TachoFault::Noisy,
            },
        },
    }
}

/// Hz to 1/min, with the digits that single precision has.
fn rpm(hz: f32) -> f64 {
    decimal(hz * 60.0)
}

fn mode(m: &ModeMessage) -> ModeRecord {
    ModeRecord {
        f: decimal(m.frequency),
        f_sd: decimal(m.frequency_sd),
        zeta: decimal(m.damping),
        zeta_sd: decimal(m.damping_sd),
        amplitude: decimal(m.amplitude),
        label: match m.label {
            decide::Label::SelfExcited => Label::SelfExcited,
            decide::Label::Structural => Label::Structural,
            decide::Label::Forced => Label::Forced,
        },
        harmonic: m.harmonic,
        origin: match m.origin {
            decide::Origin::Free => Origin::Free,
            decide::Origin::Rotation => Origin::Rotation,
            decide::Origin::Overtone => Origin::Overtone,
            decide::Origin::Background => Origin::Background,
            decide::Origin::Unknown => Origin::Unknown,
        },
        time_left: m.time_left_s.map(decimal),
        zeta_process: None,
        zeta_process_sd: None,
    }
}

fn spindle(s: &SpindleMessage) -> SpindleRecord {
    SpindleRecord {
        rpm: s.hz.map(rpm),
        source: match s.source {
            monitor::SpeedSource::Unknown => SpeedSource::Unknown,
            monitor::SpeedSource::Told => SpeedSource::Told,
            monitor::SpeedSource::Sound => SpeedSource::Sound,
            monitor::SpeedSource::Tacho => SpeedSource::Tacho,
        },
        locked: s.locked,
        notch_hz: decimal(s.notch_hz),
    }
}

fn amplitude(a: &AmplitudeMessage) -> AmplitudeRecord {
    AmplitudeRecord {
        f: decimal(a.frequency),
        s: decimal(a.scintillation),
        verdict: match a.verdict {
            decide::Amplitude::TooShort => AmplitudeVerdict::TooShort,
            decide::Amplitude::Forced => AmplitudeVerdict::Forced,
            decide::Amplitude::Suspicious => AmplitudeVerdict::Suspicious,
            decide::Amplitude::SelfExcited => AmplitudeVerdict::SelfExcited,
            decide::Amplitude::NotStationary => AmplitudeVerdict::NotStationary,
        },
        z: decimal(a.z),
    }
}

fn reason(reason: decide::Reason) -> Reason {
    match reason {
        decide::Reason::None => Reason::None,
        decide::Reason::EstimatorStarting => Reason::EstimatorStarting,
        decide::Reason::RootsLost => Reason::RootsLost,
        decide::Reason::LevelAtIdle => Reason::LevelAtIdle,
        decide::Reason::Excited => Reason::Excited,
        decide::Reason::Undamped => Reason::Undamped,
        decide::Reason::LosingDamping => Reason::LosingDamping,
        decide::Reason::ForcedOnly => Reason::ForcedOnly,
        decide::Reason::OriginUnknown => Reason::OriginUnknown,
        decide::Reason::Entering => Reason::Entering,
        decide::Reason::BlindAtMultiple => Reason::BlindAtMultiple,
        decide::Reason::Samples(condition::Fault::NotFinite) => Reason::SamplesNotFinite,
        decide::Reason::Samples(condition::Fault::Missing) => Reason::SamplesMissing,
        decide::Reason::Samples(condition::Fault::Stuck) => Reason::SamplesStuck,
        decide::Reason::Samples(condition::Fault::Clipped) => Reason::SamplesClipped,
    }
}

/// A single-precision number as the shortest decimal that stands for it, so that
/// 0.01 is printed as 0.01.
pub(crate) fn decimal(x: f32) -> f64 {
    if !x.is_finite() {
        return f64::from(x);
    }
    x.to_string().parse().unwrap_or(f64::from(x))
}
