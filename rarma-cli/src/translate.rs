//! The words of the wire in the words of the records.

use crate::record::{Alarm, AmplitudeRecord, Line, ModeRecord, NoticeKind, SpindleRecord};
use rarma_box::wire::{
    AlarmMessage, AmplitudeMessage, ModeMessage, Notice, SpindleMessage, Verdict,
};

/// A verdict as a line.
pub(crate) fn line(verdict: &Verdict, fs: f64) -> Line {
    Line {
        t: verdict.sample as f64 / fs,
        state: verdict.state,
        reason: verdict.reason,
        modes: verdict.modes.iter().map(mode).collect(),
        spindle: spindle(&verdict.spindle),
        amplitude: verdict.amplitude.as_ref().map(amplitude),
        agreement: None,
        advice: None,
    }
}

/// An alarm as it is called or released.
pub(crate) fn alarm(message: &AlarmMessage, fs: f64) -> Alarm {
    Alarm {
        on: message.sample as f64 / fs,
        off: None,
        f: decimal(message.frequency),
        zeta: decimal(message.damping),
        zeta_median: None,
        zeta_deviation: None,
        advice: None,
    }
}

/// A notice; speeds in 1/min.
pub(crate) fn notice(notice: &Notice) -> NoticeKind {
    match *notice {
        Notice::Contradiction { told_hz, found_hz } => NoticeKind::Contradiction {
            told_rpm: rpm(told_hz),
            found_rpm: rpm(found_hz),
        },
        Notice::Tacho(fault) => NoticeKind::Tacho { fault },
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
        label: m.label,
        harmonic: m.harmonic,
        origin: m.origin,
        time_left: m.time_left_s.map(decimal),
        zeta_process: None,
        zeta_process_sd: None,
    }
}

fn spindle(s: &SpindleMessage) -> SpindleRecord {
    SpindleRecord {
        rpm: s.hz.map(rpm),
        source: s.source,
        locked: s.locked,
        notch_hz: decimal(s.notch_hz),
    }
}

fn amplitude(a: &AmplitudeMessage) -> AmplitudeRecord {
    AmplitudeRecord {
        f: decimal(a.frequency),
        s: decimal(a.scintillation),
        verdict: a.verdict,
        z: decimal(a.z),
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
