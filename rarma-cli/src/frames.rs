//! Messages of a box, told in words or JSON.

use crate::advice::{AdviceRecord, AtBox, sentences};
use rarma_box::guard::{Denial, FaultCode, FaultRecord, Severity};
use rarma_box::settings::{SettingError, find};
use rarma_box::wire::{
    Answer, CircleMessage, ControlMessage, ExcitationMessage, Handed, Head, Refused, Status,
    Telemetry,
};
use rarma_recordings::one_line::{self, OneLine};
use rarma_rigs::ldbb::Proof;
use rarma_scenarios::speech::shown;
use serde::Serialize;

/// Tells the messages of a box one after the other, with what to do about its alarms.
#[derive(Debug, Clone, Default)]
pub struct Teller {
    at_box: AtBox,
}

impl Teller {
    /// A message as a line of JSON: `advice` beside the message with which speed and teeth are known, once for
    /// an alarm.
    pub fn json(&mut self, head: Head, message: &Telemetry) -> String {
        let advice = self.at_box.take(message);
        to_json(head, message, advice.as_deref())
    }

    /// A message in words; none for those that only pictures are made of.
    pub fn words(&mut self, message: &Telemetry) -> Option<String> {
        let advice = self.at_box.take(message);
        let first = advice.and_then(|advice| sentences(&advice).into_iter().next());
        match (words(message), first) {
            (Some(said), Some(first)) => Some(format!("{said}. {first}")),
            (said, first) => said.or(first),
        }
    }
}

/// A message as a line of JSON. Written out directly: a detour over a JSON value would make doubles of singles, and 0.02 would read
/// 0.0199999995529652.
pub(crate) fn to_json(head: Head, message: &Telemetry, advice: Option<&AdviceRecord>) -> String {
    let (session, sequence) = (head.session, head.sequence);
    #[derive(Serialize)]
    struct Line<'a, M> {
        session: u32,
        sequence: u32,
        message: M,
        #[serde(skip_serializing_if = "Option::is_none")]
        advice: Option<&'a AdviceRecord>,
    }
    #[derive(Serialize)]
    #[serde(rename = "Raw")]
    enum Samples {
        Raw { first: u64, samples: Vec<f32> },
    }
    let line = match message {
        // Raw samples as numbers, not as bytes.
        Telemetry::Raw(raw) => serde_json::to_string(&Line {
            session,
            sequence,
            message: Samples::Raw {
                first: raw.first,
                samples: raw.samples().collect(),
            },
            advice,
        }),
        _ => serde_json::to_string(&Line {
            session,
            sequence,
            message,
            advice,
        }),
    };
    // Numbers and names only: there is nothing that could not be written.
    one_line::json(line.unwrap_or_default())
}

/// A fault in words.
pub fn fault_words(record: &FaultRecord) -> String {
    let setting = find(record.value as u16).filter(|_| record.code.unit() == "number");
    if let Some((_, setting)) = setting
        && let Some(what) = stored_words(record.code)
    {
        return format!("{} {}: {what}", record.code.name(), setting.name);
    }
    format!(
        "{} (place {}, {} {}) at {:.4} s",
        record.code.name(),
        record.place,
        record.value,
        record.code.unit(),
        record.at_us as f64 * 1e-6
    )
}

/// What became of a stored setting, and what to do.
fn stored_words(code: FaultCode) -> Option<&'static str> {
    Some(match code {
        FaultCode::SettingRepaired => {
            "one of its two records was missing or damaged (a save without power, or flash that ages); the other is in force and stands twice again"
        }
        FaultCode::SettingOlder => {
            "its newest record is damaged and an older value is in force; read it, set it if it is wrong, and save it"
        }
        FaultCode::SettingDefault => {
            "its record is damaged and its default is in force; set and save it again"
        }
        FaultCode::SettingRefused => {
            "its record is outdated or out of range and its default is in force; set and save it again"
        }
        FaultCode::SettingOnce => {
            "it is stored once and not twice, for a part of the flash is worn out"
        }
        _ => return None,
    })
}

/// One message in words; none for those that only pictures are made of.
pub fn words(message: &Telemetry) -> Option<String> {
    Some(match message {
        Telemetry::Started { fs_hz, p, q } => format!("listening at {fs_hz} Hz, ARMA({p},{q})"),
        Telemetry::Verdict(_) | Telemetry::Raw(_) | Telemetry::Amplitude(_) => return None,
        Telemetry::Circle(CircleMessage::Points(_)) => return None,
        Telemetry::Circle(circle) => circle_words(circle),
        Telemetry::Excitation(message) => excitation_words(message),
        Telemetry::Alarm(a) => format!(
            "{} at {:.1} Hz, damping {:.2} %",
            if a.on {
                "CHATTER called"
            } else {
                "chatter released"
            },
            a.frequency,
            100.0 * a.damping
        ),
        Telemetry::Finished(f) => format!("listening ended after {} samples", f.samples),
        Telemetry::Refused(why) => format!("refused: {why:?}"),
        Telemetry::Control(control) => control_words(control),
        Telemetry::Notice(n) => format!("spindle: {:?}", n.notice),
        Telemetry::Hello(id) => {
            format!("started: {}", answer_words(&Answer::Identity(id.clone())))
        }
        Telemetry::Reply(reply) => {
            format!("answer to {}: {}", reply.to, answer_words(&reply.answer))
        }
        Telemetry::Fault(f) => format!(
            "{} in {}: {}",
            if f.severity == Severity::Trip {
                "TRIP"
            } else {
                "notice"
            },
            f.mode.name(),
            fault_words(&f.record)
        ),
        Telemetry::Status(s) => {
            format!("{:10.3} s  {}", s.now_us as f64 * 1e-6, status_words(s))
        }
        Telemetry::Health(h) => format!(
            "{:10.3} s  {} samples ({} missing), {} verdicts, {} frames ({} dropped), {} commands ({} refused, {} doubled), {} broken frames, {} times late",
            h.now_us as f64 * 1e-6,
            h.samples,
            h.missing,
            h.verdicts,
            h.frames,
            h.dropped,
            h.commands,
            h.refused,
            h.doubled,
            h.garbage,
            h.late
        ),
    })
}

/// How a box's outputs stand, and what it measures.
pub fn status_words(s: &Status) -> String {
    let fault = s.fault.map(|f| format!("  fault {}", f.code.name()));
    let press = "  (release the enable input and press it again)";
    format!(
        "{} {}{}  I {:.2} {:.2} {:.2} {:.2} A  gap {:.0} {:.0} um  p {:.2} bar  gauge {:+.1} um  supply {:.1} V{}{}",
        s.mode.name(),
        s.stage.name(),
        if s.energised { " ON" } else { "" },
        s.current_a[0],
        s.current_a[1],
        s.current_a[2],
        s.current_a[3],
        1e6 * s.gap_m[0],
        1e6 * s.gap_m[1],
        1e-5 * s.pressure_pa,
        1e6 * s.gauge_m,
        s.supply_v,
        fault.unwrap_or_default(),
        if s.press_again { press } else { "" },
    )
}

/// Who has control, in words.
pub fn control_words(control: &ControlMessage) -> String {
    let host = control.by;
    match control.why {
        Handed::Taken => format!("control: host {host:08x} has taken it"),
        Handed::Start => "control: nobody has it, the box has started".to_owned(),
        Handed::GivenUp => "control: nobody has it, it was given up".to_owned(),
        Handed::HostLost => "control: nobody has it, its host was silent".to_owned(),
        Handed::Stopped => "control: nobody has it, another host said stop".to_owned(),
    }
}

/// Why a command is refused, and what to do.
fn refused_words(why: &Refused) -> String {
    match why {
        Refused::Denied(Denial::EnableHeld) => "release the enable input and press it again",
        Refused::Denied(Denial::EnableOpen) => "the enable input is open: press it",
        Refused::Session => "made for another run of the box",
        Refused::NotInControl => "this host is not in control (take)",
        Refused::Turn => "control has changed hands meanwhile (take again)",
        Refused::Repeated => "it has come before",
        Refused::Overtaken => "a later command has come before it",
        Refused::Old => "its number is too old",
        Refused::NoKey => {
            "the box has no key, so that over a network nothing is changed (give it one at its own port, with --set-key)"
        }
        Refused::Seal => "the key is missing or another one (--key FILE)",
        Refused::OwnPort => "the key is changed at the box's own port only",
        Refused::Setting(SettingError::Range { low, high }) => {
            return format!("out of range, it takes {low} to {high}");
        }
        _ => return format!("{why:?}"),
    }
    .to_owned()
}

/// An answer in words.
pub fn answer_words(answer: &Answer) -> String {
    match answer {
        Answer::Done => "done".to_owned(),
        Answer::Refused(why) => format!("refused: {}", refused_words(why)),
        Answer::Identity(id) => format!(
            "{}, firmware {}, {} settings (schema {}), microphone {} Hz, current loop {} Hz, started by {:?}{}",
            OneLine(&id.board),
            OneLine(&id.version),
            id.settings,
            id.schema,
            id.sample_rate_hz,
            id.loop_rate_hz,
            id.started,
            id.before.map_or(String::new(), |f| format!(
                ", before that: {}",
                fault_words(&f)
            ))
        ),
        Answer::Setting(s) => {
            let (name, unit) = find(s.setting).map_or(("?", ""), |(_, row)| (row.name, row.unit));
            let stored = s
                .stored
                .map_or("not stored".to_owned(), |v| format!("stored {}", shown(v)));
            format!("{name} = {} {unit} ({stored})", shown(s.value))
        }
    }
}

fn excitation_words(message: &ExcitationMessage) -> String {
    match message {
        ExcitationMessage::Started(job) => format!(
            "excite: {} in {}, {} A rms, {} to {} Hz, for {} s",
            job.signal.name(),
            job.direction.name(),
            job.rms_a,
            job.low_hz,
            job.high_hz,
            job.seconds
        ),
        ExcitationMessage::Line(line) => {
            let [x, y] = line.receptance.map(|(re, im)| (re.hypot(im), im.atan2(re)));
            let [sx, sy] = line.sd;
            format!(
                "line {} of {}: {:8.2} Hz  {:6.2} N  x {:.4} ± {:.4} um/N {:+4.0}°  y {:.4} ± {:.4} um/N {:+4.0}°{}",
                line.line,
                if line.axis == 0 { "x" } else { "y" },
                line.f_hz,
                line.force_n,
                1e6 * x.0,
                1e6 * sx,
                x.1.to_degrees(),
                1e6 * y.0,
                1e6 * sy,
                y.1.to_degrees(),
                if line.trusted {
                    ""
                } else {
                    "  (iron near its knee)"
                }
            )
        }
        ExcitationMessage::Ended(end) => format!(
            "excite: ended{} after {} periods, {} held back by the supply, {} lines",
            if end.early { " early" } else { "" },
            end.periods,
            end.limited,
            end.lines
        ),
    }
}

fn circle_words(circle: &CircleMessage) -> String {
    match circle {
        CircleMessage::Points(p) => format!("circle {}: {} readings", p.run, p.gauge_m.len()),
        CircleMessage::Ready {
            run,
            cw,
            rising,
            pressure_pa,
        } => format!(
            "circle {run}: ready at {:.2} bar, {}, on the way {}; start the program",
            1e-5 * pressure_pa,
            if *cw { "cw" } else { "ccw" },
            if *rising { "up" } else { "down" }
        ),
        CircleMessage::Done {
            run,
            arc_s,
            pressure_pa,
            feed_m_s,
            proof,
            reversals: (seen, off_rad),
        } => format!(
            "circle {run}: done in {arc_s:.2} s, {:.3} bar, {:.0} mm/min, direction {}, {seen} reversals seen, off by {:.1}°",
            1e-5 * pressure_pa,
            6e4 * feed_m_s,
            match proof {
                Proof::None => "not proven",
                Proof::LikeBefore => "like the run before",
                Proof::Reversals => "proven",
            },
            off_rad.to_degrees()
        ),
        CircleMessage::Go { direction } => {
            format!("static: go to direction {direction}, then say go")
        }
        CircleMessage::Held {
            direction,
            step,
            force_n,
            dr_m,
            ..
        } => format!(
            "static {direction}.{step}: {force_n:.1} N, {:.2} µm",
            1e6 * dr_m
        ),
        CircleMessage::Cycle {
            direction,
            most_m,
            left_m,
            stiffness_n_per_m: (k, sd),
        } => format!(
            "static {direction}: {:.2} ± {:.2} N/µm, {:.2} µm left, {:.2} µm at most",
            1e-6 * k,
            1e-6 * sd,
            1e6 * left_m,
            1e6 * most_m
        ),
        CircleMessage::Failed { run, why } => format!("circle {run}: ended, {why:?}"),
        CircleMessage::Stiffness {
            mean_n_per_m,
            most,
            least,
            sd_n_per_m,
            ..
        } => format!(
            "stiffness {:.2} N/µm on average, {:.2} at {:.0}° to {:.2} ± {:.2} at {:.0}°",
            1e-6 * mean_n_per_m,
            1e-6 * least.0,
            least.1.to_degrees(),
            1e-6 * most.0,
            1e-6 * sd_n_per_m,
            most.1.to_degrees()
        ),
    }
}
