//! The verdict in words, and what one has to know to read the pictures.

use super::{Scene, tables};
use crate::record::{Alarm, NoticeKind, State, Summary, TachoFault};
use rarma_pictures::text::{escape, hertz, instant, percent, seconds};

/// How bad the news is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tone {
    /// It chattered.
    Bad,
    /// There were warnings.
    Careful,
    /// It did not chatter.
    Good,
    /// Nothing can be said.
    Unknown,
}

impl Tone {
    /// Name for the style sheet.
    pub fn class(self) -> &'static str {
        match self {
            Self::Bad => "bad",
            Self::Careful => "careful",
            Self::Good => "good",
            Self::Unknown => "unknown",
        }
    }

    /// A sign that tells without colour; the words say the same.
    pub(crate) fn sign(self) -> &'static str {
        match self {
            Self::Bad => "▲",
            Self::Careful => "◆",
            Self::Good => "●",
            Self::Unknown => "○",
        }
    }
}

/// Headline and the sentences below it.
pub(super) struct Verdict {
    pub(super) tone: Tone,
    pub(super) headline: String,
    pub(super) details: Vec<String>,
}

/// A run in a line, without a full stop.
pub fn headline(summary: &Summary) -> (Tone, String) {
    let spent = |state| summary.state_seconds.get(&state).copied().unwrap_or(0.0);
    let total: f64 = summary.state_seconds.values().sum();
    let cutting = spent(State::Stable) + spent(State::Warning) + spent(State::Chatter);
    let invalid = spent(State::Invalid);
    match summary.alarms.as_slice() {
        [] if spent(State::Chatter) > 0.0 => {
            let t = seconds(spent(State::Chatter));
            (
                Tone::Bad,
                format!("Chatter for {t}, without an alarm on record"),
            )
        }
        [] if total <= 0.0 => (Tone::Unknown, "No verdict: nothing was analysed".to_owned()),
        [] if invalid > 0.5 * total => (
            Tone::Unknown,
            format!(
                "No verdict: the samples could not be trusted for {}",
                seconds(invalid)
            ),
        ),
        [] if cutting <= 0.0 && spent(State::Idle) <= 0.0 => (
            Tone::Unknown,
            "No verdict: the recording ended before the monitor was ready".to_owned(),
        ),
        [] if cutting <= 0.0 => (Tone::Good, "No chatter: nothing was being cut".to_owned()),
        [] if spent(State::Warning) > 0.0 => (
            Tone::Careful,
            format!(
                "No chatter, but warnings for {}",
                seconds(spent(State::Warning))
            ),
        ),
        [] => (Tone::Good, "No chatter".to_owned()),
        [one] => {
            let until = match one.off {
                Some(off) => format!("to {}", instant(off)),
                None => "to the end".into(),
            };
            let (f, on) = (hertz(one.f), instant(one.on));
            (Tone::Bad, format!("Chatter at {f} from {on} {until}"))
        }
        [first, ..] => (
            Tone::Bad,
            format!(
                "Chatter {} times, first at {} from {}",
                summary.alarms.len() as u64 + summary.alarms_left_out,
                hertz(first.f),
                instant(first.on)
            ),
        ),
    }
}

/// The run in words a machinist can act on.
pub(super) fn verdict(scene: &Scene<'_>) -> Verdict {
    let summary = scene.job.summary;
    let (tone, headline) = headline(summary);
    let invalid = summary.state_seconds.get(&State::Invalid).copied();
    let invalid = invalid.unwrap_or(0.0);
    let mut details = Vec::new();
    details.extend(damping(scene));
    if invalid > 0.0 && tone != Tone::Unknown {
        let t = seconds(invalid);
        details.push(format!("For {t} the samples could not be trusted."));
    }
    details.extend(notices(scene));
    details.extend(against_truth(scene));
    Verdict {
        tone,
        headline,
        details,
    }
}

/// The damping of the alarm that lasted longest, beside what it is judged by.
fn damping(scene: &Scene<'_>) -> Option<String> {
    let lasted = |a: &Alarm| a.off.unwrap_or(scene.end_s) - a.on;
    let alarms = &scene.job.summary.alarms;
    let longest = alarms
        .iter()
        .max_by(|a, b| lasted(a).total_cmp(&lasted(b)))?;
    let which = match alarms.len() {
        1 => "While the alarm stood",
        _ => "While the longest alarm stood",
    };
    let said = match longest.zeta_median {
        Some(_) => " (median of the readings and their deviation)",
        None => "",
    };
    Some(format!(
        "{which}, the damping ratio of its mode was {}{said}. Below {} a mode counts as \
         undamped; above {} an alarm may be released.",
        tables::damping_words(longest),
        percent(scene.job.threshold),
        percent(scene.release())
    ))
}

/// Which stretch the pictures show, and how to see another one.
pub(super) fn on_the_window(scene: &Scene<'_>) -> String {
    if scene.job.window_s.is_some() {
        return format!(
            "<p>The pictures show {} to {} of {}; words and tables are of all of it.</p>\n",
            seconds(scene.t_start),
            seconds(scene.t_end),
            seconds(scene.end_s)
        );
    }
    let Some(span) = scene.spans.first().filter(|_| scene.dense()) else {
        return String::new();
    };
    let room = (0.5 * (span.off - span.on)).max(1.0);
    let mut from = (span.on - room).max(0.0).floor();
    let mut to = (span.off + room).min(scene.end_s).ceil();
    let mut what = "the first alarm alone";
    if to - from > 0.5 * scene.end_s {
        // It lasted for most of the recording: how it began is what can be looked at closely.
        let until = (span.on + 2.0).min(scene.end_s);
        (from, to) = ((span.on - 1.0).max(0.0).floor(), until.ceil());
        what = "how the first alarm began";
    }
    format!(
        "<p>To look at a stretch closely, give it to <code>rarma monitor</code>: \
         <code>--window {from:.0}:{to:.0}</code> draws {what}. Another folder for \
         <code>--report</code> keeps this page.</p>\n"
    )
}

/// What is wrong with what is known of the spindle; of many faults, the first ones.
fn notices(scene: &Scene<'_>) -> impl Iterator<Item = String> {
    let notices = &scene.job.summary.notices;
    notices.iter().take(4).map(|notice| {
        let t = seconds(notice.t);
        match notice.what {
            NoticeKind::Contradiction {
                told_rpm,
                found_rpm,
            } => format!(
                "The sound is that of a spindle at {found_rpm:.0} 1/min and not at the \
                 {told_rpm:.0} 1/min that were told (noticed at {t}): check the speed."
            ),
            NoticeKind::Tacho { fault } => format!(
                "The tacho {} from {t} on.",
                match fault {
                    TachoFault::Silent => "gave no pulses",
                    TachoFault::Missing => "missed pulses",
                    TachoFault::Doubled => "gave too many pulses",
                    TachoFault::Noisy => "gave pulses without a rhythm",
                }
            ),
        }
    })
}

/// How the alarms compare with what is known to have happened.
fn against_truth(scene: &Scene<'_>) -> Option<String> {
    let onset = scene.job.truth_onset_s.filter(|t| t.is_finite())?;
    let source = match scene.job.truth_note.as_deref() {
        Some(note) if !note.is_empty() => format!(" ({note})"),
        _ => String::new(),
    };
    let alarms = &scene.job.summary.alarms;
    let early = alarms.iter().filter(|a| a.on < onset).count();
    let first_after = alarms.iter().find(|a| a.on >= onset);
    let mut said = format!("The cut truly lost stability at {}{source}", seconds(onset));
    match (early, first_after) {
        (0, None) => said.push_str(" and no alarm was raised: it was missed."),
        (0, Some(a)) => said.push_str(&format!(
            "; the alarm came {} later.",
            seconds(a.on - onset)
        )),
        (n, after) => {
            let lead = seconds(onset - alarms[0].on);
            let alarm = if n == 1 { "an alarm" } else { "alarms" };
            said.push_str(&format!("; {alarm} came before it, the first {lead} early"));
            match after {
                Some(a) => said.push_str(&format!(
                    ", the first after it {} late.",
                    seconds(a.on - onset)
                )),
                None => said.push('.'),
            }
        }
    }
    Some(said)
}

/// Standard deviation of a damping ratio relative to itself, after watching for
/// `t` seconds: 1 / √(2π f ζ t).
fn relative_sd(f: f64, zeta: f64, t: f64) -> f64 {
    (std::f64::consts::TAU * f * zeta * t).sqrt().recip()
}

/// A short honest text with the uncertainty of this very run as its example.
pub(super) fn how_to_read(scene: &Scene<'_>) -> String {
    let example = example(scene);
    let forcing = match scene.forcing() {
        Some((f, name)) => format!(" Here the {name} frequency is {} at the end.", hertz(f)),
        None => {
            " Here no spindle speed was given and none was heard, so nothing could be recognised \
                 as forced by its frequency: a line may be the cutter's own hum."
                .into()
        }
    };
    format!(
        "<section aria-label=\"How to read this\">\n<h2>How to read this</h2>\n<ul>\n\
         <li><b>Damping ratio ζ</b> tells how fast a vibration dies away when nothing feeds it. \
         A machine at rest has some percent; a cut that feeds the vibration lowers it, and at \
         zero the vibration keeps itself alive.</li>\n\
         <li><b>Damping near zero alone is not chatter.</b> Anything that hums steadily, such as \
         a tooth passing at each turn, looks undamped as well. Chatter is called when a mode is \
         undamped, lies away from the multiples of the spindle speed, and stays so.</li>\n\
         <li><b>Forced</b> means: at a multiple of the spindle or tooth frequency. It stops with \
         the spindle and does not grow by itself. <b>Structural</b> is a damped resonance of \
         machine, tool or workpiece. <b>Self-excited</b> is undamped and no multiple.{}</li>\n\
         <li><b>Damping is never known exactly.</b> Watching a mode for T seconds leaves \
         sd(ζ)/ζ ≈ 1/√(2π f ζ T){}. One low point is not a finding; a row of them is.</li>\n\
         <li>Chatter that lies very close to a multiple of the spindle speed can pass for forced, \
         and two modes closer together than the model can part appear as one.</li>\n\
         </ul>\n</section>\n",
        escape(&forcing),
        escape(&example)
    )
}

/// The rule with the numbers of this run.
fn example(scene: &Scene<'_>) -> String {
    let alarm = scene.spans.first().map(|s| s.f);
    let Some(f) = alarm
        .filter(|f| f.is_finite() && *f > 0.0)
        .or(scene.job.course.first_hz)
    else {
        return String::new();
    };
    let zeta = scene.job.threshold;
    if !(zeta.is_finite() && zeta > 0.0) {
        return String::new();
    }
    format!(
        ": at {} a damping ratio of {} is known to ± {} of itself after {}, to ± {} after {}",
        hertz(f),
        percent(zeta),
        percent(relative_sd(f, zeta, 0.1)),
        seconds(0.1),
        percent(relative_sd(f, zeta, 1.0)),
        seconds(1.0)
    )
}
