//! The JSON of `monitor` and `listen`: lines, then a summary.

use super::{ConvertError, list, number, text};
use crate::record::{
    Advice, AlarmCalled, AlarmReleased, Body, Name, OdrStatistics, Speed, State, Utc, Verdict,
};
use rarma_core::named::Named;
use serde_json::Value;

/// Most speeds of an advice in a record.
const MOST_SPEEDS: usize = 8;
/// Portions over which the deviation of a mean is taken: neighbouring readings are not independent.
const PORTIONS: usize = 10;

pub(super) fn said(values: &[Value], start: Utc) -> Result<Vec<(Utc, Body)>, ConvertError> {
    let summary = &values[values.len() - 1]["summary"];
    let mut all = stretches(summary, start)?;
    let rpm = number(&summary["spindle"], "rpm_last").ok();
    for alarm in list(summary, "alarms")? {
        of_alarm(alarm, start, rpm, &mut all)?;
    }
    all.extend(statistics(&values[..values.len() - 1], rpm).map(|body| (start, body)));
    Ok(all)
}

/// Seconds in each state, one after the other: which came when stands in the lines, and is not kept.
fn stretches(summary: &Value, start: Utc) -> Result<Vec<(Utc, Body)>, ConvertError> {
    let seconds = summary["state_seconds"].as_object();
    let seconds = seconds.ok_or_else(|| ConvertError::Field("state_seconds".to_owned()))?;
    let stretch = |(state, seconds): (&String, &Value)| {
        let state = State::of_name(state)
            .ok_or_else(|| ConvertError::Field(format!("the state {state:?}")))?;
        let seconds = seconds
            .as_f64()
            .ok_or_else(|| ConvertError::Field("state_seconds".to_owned()))?;
        let reason = Name::new("whole-recording")?;
        let verdict = Verdict {
            state,
            reason,
            seconds,
            level: None,
            rpm: None,
            modes: Vec::new(),
        };
        Ok((start, Body::Verdict(verdict)))
    };
    seconds.iter().map(stretch).collect()
}

/// The call, the advice and the release of an alarm. Their places in the list are their `seq`.
fn of_alarm(
    alarm: &Value,
    start: Utc,
    rpm: Option<f64>,
    all: &mut Vec<(Utc, Body)>,
) -> Result<(), ConvertError> {
    let (on, f_hz, zeta) = (
        number(alarm, "on")?,
        number(alarm, "f")?,
        number(alarm, "zeta")?,
    );
    let advice = alarm.get("advice").filter(|a| a.is_object());
    let rpm = advice.and_then(|a| number(a, "rpm").ok()).or(rpm);
    let called = all.len() as u64;
    all.push((
        start.plus_s(on),
        Body::AlarmCalled(AlarmCalled {
            f_hz,
            zeta,
            rpm,
            teeth: None,
        }),
    ));
    if let Some(advice) = advice {
        let speed = |s: &Value| {
            Ok(Speed {
                rpm: number(s, "rpm")?,
                rpm_sd: Some(number(s, "rpm_sd")?),
                chance: Some(number(s, "chance")?),
                margin: Some(number(s, "margin")?),
            })
        };
        let speeds = list(advice, "speeds")?.iter().take(MOST_SPEEDS).map(speed);
        let helps = list(advice, "helps")
            .unwrap_or_default()
            .iter()
            .filter_map(Value::as_str);
        let body = Body::Advice(Advice {
            called: Some(called),
            rpm: number(advice, "rpm")?,
            f_hz: number(advice, "mode")?,
            speeds: speeds.collect::<Result<_, ConvertError>>()?,
            helps: helps
                .filter_map(|h| Name::new(h).ok())
                .take(MOST_SPEEDS)
                .collect(),
        });
        all.push((start.plus_s(on), body));
    }
    // One that still stands at the end was not released.
    if let Ok(off) = number(alarm, "off") {
        let body = Body::AlarmReleased(AlarmReleased {
            called,
            seconds: off - on,
            f_hz,
            zeta_lowest: zeta,
            zeta_median: number(alarm, "zeta_median").ok(),
            rpm,
        });
        all.push((start.plus_s(off), body));
    }
    Ok(())
}

/// A reading of the damping: when, at which frequency, how much.
type Reading = (f64, f64, f64);

/// Damping of the mode that is least damped most of the time, over the lines in which something was cut.
/// `None` with fewer than ten times as many readings as portions, or without a speed.
fn statistics(lines: &[Value], rpm: Option<f64>) -> Option<Body> {
    let mut readings: Vec<Reading> = lines.iter().filter_map(least_damped).collect();
    let rpm = rpm.or_else(|| lines.iter().find_map(|l| number(&l["spindle"], "rpm").ok()))?;
    let middle = |values: &mut Vec<f64>, part: f64| {
        values.sort_by(f64::total_cmp);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a place"
        )]
        let place = (part * (values.len() - 1) as f64).round() as usize;
        values[place]
    };
    if readings.len() < 10 * PORTIONS {
        return None;
    }
    let f_hz = middle(&mut readings.iter().map(|r| r.1).collect(), 0.5);
    readings.retain(|r| (r.1 / f_hz - 1.0).abs() < 0.05);
    let count = readings.len();
    if count < 10 * PORTIONS {
        return None;
    }
    let mean = |part: &[Reading]| part.iter().map(|r| r.2).sum::<f64>() / part.len() as f64;
    let zeta_mean = mean(&readings);
    let portions: Vec<f64> = readings
        .chunks_exact(count / PORTIONS)
        .take(PORTIONS)
        .map(mean)
        .collect();
    let scatter: f64 = portions.iter().map(|m| (m - zeta_mean).powi(2)).sum();
    let n = PORTIONS as f64;
    let mut zetas: Vec<f64> = readings.iter().map(|r| r.2).collect();
    let step = (readings[count - 1].0 - readings[0].0) / (count - 1) as f64;
    Some(Body::OdrStatistics(OdrStatistics {
        rpm,
        f_hz,
        count: count as u64,
        seconds: step * count as f64,
        zeta_mean,
        zeta_mean_sd: (scatter / (n * (n - 1.0))).sqrt(),
        zeta_tenths: [0.1, 0.5, 0.9].map(|part| middle(&mut zetas, part)),
    }))
}

/// The least damped mode of a line in which something is cut, that is not forced.
fn least_damped(line: &Value) -> Option<Reading> {
    let state = text(line, "state").ok()?;
    if !["stable", "warning", "chatter"].contains(&state) {
        return None;
    }
    let modes = list(line, "modes")
        .ok()?
        .iter()
        .filter(|m| text(m, "label").is_ok_and(|l| l != "forced"));
    let read = |m: &Value| {
        Some((
            number(line, "t").ok()?,
            number(m, "f").ok()?,
            number(m, "zeta").ok()?,
        ))
    };
    modes.filter_map(read).min_by(|a, b| a.2.total_cmp(&b.2))
}
