//! Alarms and settings as tables.

use super::course::ROWS;
use super::{Scene, amplitude};
use crate::record::{Alarm, Fault, Reason, State};
use rarma_core::named::Named;
use rarma_pictures::put;
use rarma_pictures::text::{
    count, escape, hertz, instant, percent, percent_within, seconds, significant, with_unit,
};

/// One row per alarm.
pub(super) fn alarms(scene: &Scene<'_>) -> String {
    let alarms = &scene.job.summary.alarms;
    let mut html = String::from("<section aria-label=\"Alarms\">\n<h2>Alarms</h2>\n");
    if alarms.is_empty() {
        html.push_str("<p>None.</p>\n</section>\n");
        return html;
    }
    let forcing = scene.forcing();
    html.push_str(
        "<div class=\"scroll\"><table>\n<thead><tr><th scope=\"col\">No.</th>\
         <th scope=\"col\">from</th><th scope=\"col\">to</th><th scope=\"col\">lasted</th>\
         <th scope=\"col\">frequency</th>",
    );
    if let Some((_, name)) = forcing {
        put!(html, "<th scope=\"col\">in multiples of {name}</th>");
    }
    html.push_str(
        "<th scope=\"col\">nearest multiple of the spindle</th>\
         <th scope=\"col\">damping ratio ζ while it stood</th><th scope=\"col\">amplitude</th></tr></thead>\n<tbody>\n",
    );
    for (i, alarm) in alarms.iter().take(ROWS).enumerate() {
        let end = alarm.off.unwrap_or(scene.end_s);
        put!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
            i + 1,
            instant(alarm.on),
            match alarm.off {
                Some(off) => instant(off),
                None => "still on at the end".into(),
            },
            seconds(end - alarm.on),
            hertz(alarm.f),
        );
        let noted = scene.job.course.noted(i, alarm).unwrap_or_default();
        let turn = scene.spindle(noted.rpm);
        if forcing.is_some() {
            let then = turn.map(|turn| scene.forcing_of(turn));
            let multiple = then.map(|(f, _)| with_unit(alarm.f / f, "×"));
            put!(html, "<td>{}</td>", multiple.unwrap_or_else(|| "–".into()));
        }
        let nearest = turn.map(|f| nearest(alarm.f, f));
        let said = noted.said.map(amplitude::word);
        put!(
            html,
            "<td>{}</td><td>{}</td><td>{}</td></tr>\n",
            nearest.unwrap_or_else(|| "speed not known".into()),
            damping_words(alarm),
            said.unwrap_or("too short to tell")
        );
    }
    html.push_str("</tbody>\n</table></div>\n");
    let all = alarms.len() as u64 + scene.job.summary.alarms_left_out;
    if all > ROWS as u64 {
        put!(
            html,
            "<p>{} alarms more are not listed.</p>\n",
            count(all - ROWS as u64)
        );
    }
    html.push_str("</section>\n");
    html
}

/// Median and deviation of an alarm's damping ratio; of one without, the lowest.
pub fn damping_words(alarm: &Alarm) -> String {
    match (alarm.zeta_median, alarm.zeta_deviation) {
        (Some(median), Some(deviation)) => percent_within(median, deviation),
        _ => format!("down to {}", percent(alarm.zeta)),
    }
}

/// The nearest multiple of a spindle frequency, and how far off it is.
fn nearest(f: f64, spindle_hz: f64) -> String {
    let n = (f / spindle_hz).round().max(1.0);
    if !n.is_finite() {
        return "–".into();
    }
    let off = f - n * spindle_hz;
    let side = if off < 0.0 { "below" } else { "above" };
    format!("{} {side} {n:.0} × {}", hertz(off.abs()), hertz(spindle_hz))
}

/// A reason in a sentence.
pub fn reason_words(state: State, reason: Reason) -> &'static str {
    match reason {
        Reason::None => match state {
            State::Chatter => "a mode is self-excited: an alarm stands",
            State::Stable => "every mode is damped",
            _ => "nothing to remark",
        },
        Reason::EstimatorStarting => "the model is starting",
        Reason::RootsLost => "the modes are sought anew",
        Reason::LevelAtIdle => "as quiet as at idle",
        Reason::Excited => "shaken by the exciter: no verdict",
        Reason::Undamped => "a mode is undamped, too short to be called",
        Reason::LosingDamping => "a mode loses its damping",
        Reason::ForcedOnly => "undamped, but something else explains it",
        Reason::OriginUnknown => {
            "undamped, and it cannot be told whether forced: the speed is missing"
        }
        Reason::Entering => "the cut has just begun",
        Reason::BlindAtMultiple => {
            "a line of the rotation rose by itself: chatter there would not be told from it"
        }
        Reason::Samples(Fault::NotFinite) => "samples are NaN or infinite",
        Reason::Samples(Fault::Missing) => "samples are missing",
        Reason::Samples(Fault::Stuck) => "samples do not move",
        Reason::Samples(Fault::Clipped) => "samples are clipped",
    }
}

/// How long the state was what it was for which reason.
pub(super) fn reasons(scene: &Scene<'_>) -> String {
    let spent = scene.job.course.spent(scene.end_s);
    if spent.is_empty() {
        return String::new();
    }
    let mut html = String::from(
        "<section aria-label=\"Reasons\">\n<h2>Why</h2>\n<div class=\"scroll\"><table>\n\
         <thead><tr><th scope=\"col\">time</th><th scope=\"col\">state</th>\
         <th scope=\"col\">reason</th></tr></thead>\n<tbody>\n",
    );
    for (state, reason, passed) in spent {
        put!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            seconds(passed),
            state.name(),
            reason_words(state, reason)
        );
    }
    html.push_str("</tbody>\n</table></div>\n</section>\n");
    html
}

/// The spindle as it was heard, in words.
fn heard(scene: &Scene<'_>) -> Option<String> {
    let summary = scene.job.summary;
    let spindle = &summary.spindle;
    let (first, last) = (spindle.rpm_first?, spindle.rpm_last?);
    let mut said = format!(
        "{first:.0} 1/min at first, {last:.0} 1/min at last; multiples removed for {}",
        seconds(spindle.locked_s)
    );
    if let Some(notch) = spindle.notch_hz {
        said.push_str(&format!(", deaf within {} of each", hertz(notch)));
    }
    if let Some(db) = summary.removed_db {
        said.push_str(&format!(", {} of all energy", with_unit(db, "dB")));
    }
    Some(said)
}

/// What the run was made with, and how long it was in which state.
pub(super) fn settings(scene: &Scene<'_>) -> String {
    let job = scene.job;
    let summary = job.summary;
    let [p, q] = summary.order;
    let mut rows = vec![
        ("Source", escape(job.source_name)),
        (
            "Samples",
            format!(
                "{} at {}, {}",
                count(job.sound.heard()),
                hertz(job.fs),
                seconds(job.sound.heard() as f64 / scene.fs)
            ),
        ),
        (
            "Samples analysed",
            format!("{} at {}", count(summary.samples), hertz(summary.fs)),
        ),
        (
            "Model",
            format!("ARMA({p}, {q}), identified again at every sample"),
        ),
        (
            "Threshold",
            format!(
                "ζ = {}; released by damping above {}",
                percent(job.threshold),
                percent(scene.release())
            ),
        ),
        (
            "Band",
            format!("{} to {}", hertz(job.band_hz.0), hertz(job.band_hz.1)),
        ),
        (
            "Spindle speed",
            match job.rpm {
                Some(rpm) => format!("{} ({})", with_unit(rpm, "1/min"), hertz(rpm / 60.0)),
                None => "not given".into(),
            },
        ),
        (
            "Teeth",
            job.teeth.map_or("not given".into(), |z| z.to_string()),
        ),
    ];
    if let Some(heard) = heard(scene) {
        rows.push(("Spindle, as read", heard));
    }
    if let Some((f, name)) = scene.forcing().filter(|(_, name)| *name != "spindle") {
        let name = if name == "tooth passing" {
            "Tooth passing"
        } else {
            name
        };
        rows.push((name, hertz(f)));
    }
    if let Some(onset) = job.truth_onset_s {
        let note = job.truth_note.as_deref().unwrap_or_default();
        let note = if note.is_empty() {
            String::new()
        } else {
            format!(" ({})", escape(note))
        };
        rows.push(("True onset", format!("{}{note}", seconds(onset))));
    }
    let states: Vec<String> = summary
        .state_seconds
        .iter()
        .filter(|(_, t)| t.is_finite() && **t > 0.0)
        .map(|(state, t)| format!("{} {}", state.name(), seconds(*t)))
        .collect();
    if !states.is_empty() {
        rows.push(("Time in each state", states.join(", ")));
    }
    if let Some(amplitude) = job.course.strongest {
        rows.push((
            "Strongest mode",
            format!("{} input units, peak", significant(amplitude)),
        ));
    }
    rows.extend(job.provenance.rows());
    let mut html = String::from(
        "<section aria-label=\"Settings\">\n<h2>Settings</h2>\n<div class=\"scroll\">\
         <table class=\"pairs\">\n<tbody>\n",
    );
    for (key, value) in rows {
        put!(
            html,
            "<tr><th scope=\"row\">{key}</th><td>{value}</td></tr>\n"
        );
    }
    html.push_str("</tbody>\n</table></div>\n</section>\n");
    html
}
