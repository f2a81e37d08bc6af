//! Records in words: the same in lines and on a screen.

use crate::record::{Alarm, NoticeKind, NoticeRecord, TachoFault};
use crate::report::damping_words;

/// That an alarm was called.
pub(crate) fn called(alarm: &Alarm) -> String {
    let (f, zeta) = (alarm.f, 100.0 * alarm.zeta);
    format!("CHATTER called: {f:.1} Hz, damping {zeta:.2} %")
}

/// That it was released.
pub(crate) fn released(alarm: &Alarm) -> String {
    let (f, damping) = (alarm.f, damping_words(alarm));
    format!("released; it was at {f:.1} Hz, damping {damping}")
}

/// A notice, and what to do about it.
pub(crate) fn notice(notice: &NoticeRecord) -> String {
    let t = notice.t;
    match notice.what {
        NoticeKind::Contradiction {
            told_rpm,
            found_rpm,
        } => format!(
            "Warning: at {t:.2} s the sound is that of a spindle at {found_rpm:.0} 1/min, not at the {told_rpm:.0} 1/min that were told: check the speed and give the true one with --rpm; until then a line on a multiple of {found_rpm:.0} 1/min is of unknown origin."
        ),
        NoticeKind::Tacho { fault } => {
            let what = match fault {
                TachoFault::Silent => {
                    "gives no pulses: check that it is connected and which channel it is"
                }
                TachoFault::Missing => "misses pulses: check its distance and its level",
                TachoFault::Doubled => {
                    "gives too many pulses: check --pulses and that it does not bounce"
                }
                TachoFault::Noisy => {
                    "gives pulses without a rhythm: check the channel and its cable"
                }
            };
            format!("Warning: at {t:.2} s the tacho {what}.")
        }
    }
}
