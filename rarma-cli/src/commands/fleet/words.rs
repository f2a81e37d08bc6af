//! Changes of a machine, in words.

use rarma_fleet::record::Utc;
use rarma_fleet::trends::change::Change;
use rarma_fleet::trends::series::SeriesKind;

/// What has changed, in a few words.
pub(super) fn subject(change: &Change) -> String {
    match (change.what, change.direction_deg) {
        (SeriesKind::Plane, Some(angle)) => {
            let sd = change.direction_sd_deg.unwrap_or(0.0);
            format!(
                "stiffness of {} at {angle:.0}° ± {:.0}°",
                change.place,
                2.0 * sd
            )
        }
        (SeriesKind::Plane, None) => format!("stiffness of {}, all directions alike", change.place),
        (SeriesKind::Frequency, _) => {
            format!("frequency of {} at {:.0} Hz", place(change), change.at)
        }
        (SeriesKind::Damping, _) => format!("damping of {} at {:.0} Hz", place(change), change.at),
        (SeriesKind::Limit, _) => format!("limit of width at {:.0}°", change.at),
        (SeriesKind::Hysteresis, _) => format!("loops of {}", change.place),
        (kind, _) => error(kind, &change.place),
    }
}

/// `XY backlash_um.0` is the backlash of X.
fn error(kind: SeriesKind, place: &str) -> String {
    let (plane, name) = place.split_once(' ').unwrap_or((place, ""));
    let axis = (name.rsplit_once('.'))
        .and_then(|(_, n)| plane.chars().nth(n.parse().ok()?))
        .map_or_else(|| plane.to_owned(), String::from);
    format!("{} of {axis}", name_of(kind))
}

/// What a series is of, in words.
pub(super) fn name_of(kind: SeriesKind) -> &'static str {
    match kind {
        SeriesKind::Plane => "stiffness",
        SeriesKind::Frequency => "frequency",
        SeriesKind::Damping => "damping",
        SeriesKind::Limit => "limit of width",
        SeriesKind::Hysteresis => "loops",
        SeriesKind::ScaleMismatch => "scale mismatch",
        SeriesKind::Squareness => "squareness",
        SeriesKind::Straightness => "straightness",
        SeriesKind::Backlash => "backlash",
        SeriesKind::LateralPlay => "lateral play",
        SeriesKind::ServoMismatch => "servo mismatch",
    }
}

/// `X 0` is axis X at rest.
fn place(change: &Change) -> String {
    match change.place.split_once(' ') {
        Some((axis, "0")) => axis.to_owned(),
        Some((axis, rpm)) => format!("{axis} ({rpm} 1/min)"),
        None => change.place.clone(),
    }
}

pub(super) fn day(time: Utc) -> String {
    time.to_string().chars().take(10).collect()
}

pub(super) fn size(change: &Change) -> String {
    let (value, sd, unit) = match change.unit {
        Some(unit) => (change.amount, change.amount_sd, unit),
        None => (change.percent, change.percent_sd, "%"),
    };
    let (value, sd) = (value.unwrap_or(0.0), 2.0 * sd.unwrap_or(0.0));
    // Two digits of what is left open.
    let digits = if sd < 0.1 { 2 } else { 1 };
    format!("{value:+.digits$} ± {sd:.digits$} {unit}")
}

/// What a change does to the limit of depth, where it says something of it.
pub(super) fn limit(change: &Change) -> Option<String> {
    change.limit_percent.map(|p| format!("{p:+.1} %"))
}
