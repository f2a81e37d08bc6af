//! What a box says of a day: cuts, alarms, advice, what came of it, and damping by tool and speed.

use super::life::Life;
use super::machine::{Drawn, TrueMode};
use super::says::Says;
use crate::record::{
    Advice, AlarmCalled, AlarmReleased, Body, Label, Mode, Name, OdrStatistics, Outcome, Speed,
    State, Verdict,
};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Poisson, StandardNormal};

const OPERATORS: [&str; 3] = ["early", "late", "night"];
/// Tools, each with its teeth and speed.
const TOOLS: [(&str, u32, f64); 6] = [
    ("T01", 2, 9000.0),
    ("T02", 3, 7200.0),
    ("T03", 4, 4800.0),
    ("T04", 4, 3000.0),
    ("T05", 5, 2400.0),
    ("T06", 6, 1800.0),
];
/// Cuts of a shift.
const CUTS: usize = 7;
/// Part of the alarms whose advice has a speed; part of that which is turned; part of those that helped; and
/// part of those not followed where the chatter ended all the same.
const ADVISED: f64 = 0.8;
const FOLLOWED: f64 = 0.6;
const HELPED: f64 = 0.8;
const ENDED_ANYWAY: f64 = 0.25;

fn name(text: &str) -> Name {
    Name::new(text).expect("a short word")
}

fn verdict(state: State, reason: &str, seconds: f64, cut: Option<(&TrueMode, f64, f64)>) -> Body {
    let modes = cut.map(|(mode, zeta, _)| Mode {
        f_hz: (mode.f_hz * 10.0).round() / 10.0,
        f_sd_hz: 1.5,
        zeta: (zeta * 1e5).round() / 1e5,
        zeta_sd: 0.002,
        amplitude: 0.05,
        label: if zeta < 0.0 {
            Label::SelfExcited
        } else {
            Label::Structural
        },
    });
    Body::Verdict(Verdict {
        state,
        reason: name(reason),
        seconds: seconds.round(),
        level: None,
        rpm: cut.map(|(_, _, rpm)| rpm),
        modes: modes.into_iter().collect(),
    })
}

pub(super) fn of_day(says: &mut Says, drawn: &Drawn, life: &Life, rng: &mut ChaCha8Rng) {
    let now = life.at(drawn, f64::from(says.day()));
    // The nearer the usual cuts are to the limit, the more alarms.
    let worse = (drawn.new.limit_mm() / now.limit_mm()).powi(3);
    let alarms = Poisson::new(drawn.alarms_a_day * worse).map_or(0.0, |p| p.sample(rng));
    let mean = alarms / (OPERATORS.len() * CUTS) as f64;
    for (shift, operator) in OPERATORS.into_iter().enumerate() {
        let length = 1.0 / (OPERATORS.len() * CUTS) as f64;
        for cut in 0..CUTS {
            let at = shift as f64 / 3.0 + cut as f64 * length;
            let (tool, teeth, rpm) = TOOLS[rng.random_range(0..TOOLS.len())];
            let mode = &now.modes[rng.random_range(0..now.modes.len())];
            let idle = rng.random_range(0.1..0.5) * length;
            says.by_box(
                at,
                tool,
                operator,
                verdict(State::Idle, "level-at-idle", idle * 86_400.0, None),
            );
            let zeta = mode.zeta * rng.random_range(0.3..0.9);
            let cutting = (length - idle) * 86_400.0;
            let body = verdict(State::Stable, "none", cutting, Some((mode, zeta, rpm)));
            says.by_box(at + idle, tool, operator, body);
            if rng.random::<f64>() < mean {
                let called = at + idle + rng.random_range(0.2..0.6) * (length - idle);
                alarm(says, called, (tool, operator), (mode, teeth, rpm), rng);
            }
        }
    }
    if says.day() % 7 == 6 {
        for (tool, _, rpm) in TOOLS {
            let mode = &now.modes[0];
            let sd = 0.03 * mode.zeta;
            let scatter: f64 = StandardNormal.sample(rng);
            let mean = 0.6 * mode.zeta + sd * scatter;
            let body = Body::OdrStatistics(OdrStatistics {
                rpm,
                f_hz: mode.f_hz,
                count: 20_000,
                seconds: 2000.0,
                zeta_mean: mean,
                zeta_mean_sd: sd,
                zeta_tenths: [0.5 * mean, mean, 1.5 * mean],
            });
            says.by_box(0.999, tool, "", body);
        }
    }
}

fn alarm(
    says: &mut Says,
    at: f64,
    (tool, operator): (&str, &str),
    (mode, teeth, rpm): (&TrueMode, u32, f64),
    rng: &mut ChaCha8Rng,
) {
    let f_hz = mode.f_hz * rng.random_range(1.0..1.08);
    let seconds: f64 = rng.random_range(0.5..20.0);
    let zeta = -rng.random_range(0.001..0.02);
    let second = 1.0 / 86_400.0;
    let body = Body::AlarmCalled(AlarmCalled {
        f_hz,
        zeta,
        rpm: Some(rpm),
        teeth: Some(teeth),
    });
    let called = says.by_box(at, tool, operator, body);
    let speeds = (rng.random::<f64>() < ADVISED).then(|| Speed {
        rpm: rpm * rng.random_range(0.85..1.2),
        rpm_sd: Some(60.0),
        chance: Some(rng.random_range(0.6..0.95)),
        margin: Some(rng.random_range(1.2..3.0)),
    });
    let advised = speeds.is_some();
    let body = Body::Advice(Advice {
        called: Some(called),
        rpm,
        f_hz: mode.f_hz,
        speeds: speeds.into_iter().collect(),
        helps: if advised {
            Vec::new()
        } else {
            vec![name("less-depth")]
        },
    });
    let advice = says.by_box(at + 0.1 * second, tool, operator, body);
    let followed = advised && rng.random::<f64>() < FOLLOWED;
    let helped = rng.random::<f64>() < if followed { HELPED } else { ENDED_ANYWAY };
    let body = Body::AlarmReleased(AlarmReleased {
        called,
        seconds,
        f_hz,
        zeta_lowest: zeta,
        zeta_median: Some(zeta * 0.6),
        rpm: Some(rpm),
    });
    says.by_box(at + seconds * second, tool, operator, body);
    let body = Body::Outcome(Outcome {
        advice,
        followed,
        rpm: Some(if followed { rpm * 1.1 } else { rpm }),
        helped: Some(helped),
        why: None,
    });
    says.by_box(at + (seconds + 1.0) * second, tool, operator, body);
}
