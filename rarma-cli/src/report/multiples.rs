//! The multiples of the spindle's speed, drawn as that went over time.

use super::Scene;
use rarma_pictures::Axis;
use rarma_pictures::free;
use rarma_pictures::put;
use rarma_pictures::text::{hertz, px};
use rarma_pictures::{LEFT, Panel, RIGHT};

/// Lines closer than this are not drawn: they would hide what lies between them, pixels.
const MERGE: f64 = 6.0;
/// Below this distance not even ticks at the edge can be told apart, pixels.
const LEAST_TICK: f64 = 2.2;
/// One point of the speed in so many pixels.
const STEP: f64 = 3.0;
/// A change of the speed by less than this part of it is not seen.
const UNSEEN: f64 = 5e-4;

/// What was drawn, for the legend and the caption.
pub(super) struct Drawn {
    /// Sentences for the caption.
    pub(super) caption: String,
    /// What the strong lines are multiples of.
    pub(super) name: &'static str,
}

/// Draws thin lines at the multiples of the spindle's speed and stronger ones at those of
/// the tooth passing, numbered in the right margin where there is room if `numbered`.
/// `None` where no speed is known or all lines would merge.
pub(super) fn draw(
    panel: &mut Panel<'_>,
    scene: &Scene<'_>,
    y: &Axis,
    class: &str,
    numbered: Option<Vec<f64>>,
) -> Option<Drawn> {
    let stretches = track(panel, scene);
    let (_, first) = *stretches.first()?.first()?;
    let (_, last) = *stretches.last()?.last()?;
    let teeth = scene.teeth_of_the_speed();
    let gap = y.at(0.0) - y.at(first);
    let strong_gap = gap * f64::from(teeth.unwrap_or(1));
    if strong_gap < MERGE {
        return None;
    }
    let speeds = || stretches.iter().flatten().map(|(_, f)| *f);
    let least = speeds().fold(f64::MAX, f64::min);
    let most = speeds().fold(0.0, f64::max);
    let (mut thin, mut strong) = (String::new(), String::new());
    for n in 1..=(y.hi() / least) as u32 {
        let is_strong = teeth.is_none_or(|z| n.is_multiple_of(z));
        if is_strong {
            line(&mut strong, &stretches, y, f64::from(n));
        } else if gap >= MERGE {
            line(&mut thin, &stretches, y, f64::from(n));
        } else if gap >= LEAST_TICK && y.holds(f64::from(n) * first) {
            put!(thin, "M{LEFT} {}h7", px(y.at(f64::from(n) * first)));
        }
    }
    panel.add(&format!(
        r#"<path class="{class}" d="{thin}"/><path class="{class} tooth" d="{strong}"/>"#
    ));
    if let Some(mut taken) = numbered {
        let step = last * f64::from(teeth.unwrap_or(1));
        for k in 1..=(y.hi() / step) as u32 {
            let at = y.at(f64::from(k) * step);
            if free(&taken, at) {
                taken.push(at);
                panel.margin(at, "small", &format!("{k}×"));
            }
        }
    }
    let (name, mut caption) = match teeth {
        Some(z) => (
            "tooth passing",
            format!(
                " Lines: multiples of the tooth passing, {}",
                range(least * f64::from(z), most * f64::from(z))
            ),
        ),
        None => (
            "spindle",
            format!(" Lines: multiples of the spindle, {}", range(least, most)),
        ),
    };
    if teeth.is_some() {
        let at = range(least, most);
        caption.push_str(&match gap {
            g if g >= MERGE => format!("; thinner ones: of the spindle, {at}"),
            g if g >= LEAST_TICK => format!(
                "; ticks at the left edge: of the spindle, {at}, too close to be drawn across"
            ),
            _ => format!("; those of the spindle, {at}, are too close to be drawn"),
        });
    }
    caption.push('.');
    Some(Drawn { caption, name })
}

/// A frequency that keeps between two.
fn range(least: f64, most: f64) -> String {
    if most - least > 2e-3 * least {
        format!("{} to {}", hertz(least), hertz(most))
    } else {
        hertz(least)
    }
}

/// One multiple over all stretches.
fn line(d: &mut String, stretches: &[Vec<(f64, f64)>], y: &Axis, n: f64) {
    for stretch in stretches {
        let mut pen = 'M';
        for &(x, f) in stretch {
            if y.holds(n * f) {
                put!(d, "{pen}{} {}", px(x), px(y.at(n * f)));
                pen = 'L';
            } else {
                pen = 'M';
            }
        }
    }
}

/// Place and speed (Hz), in stretches in which it was known; few points where it is
/// steady. A speed that only the settings know holds all the time.
fn track(panel: &Panel<'_>, scene: &Scene<'_>) -> Vec<Vec<(f64, f64)>> {
    let mut stretches: Vec<Vec<(f64, f64)>> = Vec::new();
    let (mut known, mut column) = (false, f64::MIN);
    let mut before = None;
    for moment in scene.job.course.moments() {
        let x = panel.x.at(moment.t);
        let hz = moment.rpm.map(|rpm| rpm / 60.0);
        let Some(hz) = hz.filter(|f| f.is_finite() && *f > 0.0) else {
            if let (Some(last), Some(end)) = (stretches.last_mut(), before.take()) {
                last.push(end);
            }
            known = false;
            continue;
        };
        if !known {
            stretches.push(vec![(x, hz)]);
            (known, column, before) = (true, x, None);
            continue;
        }
        if x < column + STEP {
            continue;
        }
        column = x;
        let Some(last) = stretches.last_mut() else {
            continue;
        };
        let there = last.last().map_or(hz, |p| p.1);
        if (hz - there).abs() > UNSEEN * there {
            last.extend(before.take());
            last.push((x, hz));
        } else {
            before = Some((x, there));
        }
    }
    if let (Some(last), true) = (stretches.last_mut(), known)
        && let Some(&(_, hz)) = last.last()
    {
        last.push((panel.x.at(scene.t_end), hz));
    }
    if stretches.is_empty() {
        let told = scene.job.rpm.filter(|rpm| rpm.is_finite() && *rpm > 0.0);
        stretches.extend(told.map(|rpm| vec![(LEFT, rpm / 60.0), (RIGHT, rpm / 60.0)]));
    }
    stretches
}
