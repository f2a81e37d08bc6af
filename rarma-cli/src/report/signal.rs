//! Picture (a): the signal, as the band between least and largest sample.

use super::Scene;
use rarma_pictures::Axis;
use rarma_pictures::put;
use rarma_pictures::text::{px, seconds, significant};
use rarma_pictures::{LEFT, RIGHT, TOP};

const HEIGHT: f64 = 120.0;

/// Draws the figure.
pub(super) fn figure(scene: &Scene<'_>) -> String {
    let sound = scene.job.sound;
    let (low, high) = sound.ends().unwrap_or((f64::MAX, f64::MIN));
    let mut panel = scene.panel(HEIGHT, "(a) Signal");
    let y = if low <= high {
        let room = 0.06 * (high - low) + 1e-12 * high.abs().max(low.abs());
        Axis::linear(low - room, high + room, panel.bottom, TOP)
    } else {
        Axis::linear(-1.0, 1.0, panel.bottom, TOP)
    };
    panel.axes(&y, 6, "input units");
    panel.spans();
    let path = match sound.whole() {
        Some(samples) if samples.len() <= 2 * columns() => line(samples, scene, &panel.x, &y),
        _ => envelope(scene, &panel.x, &y),
    };
    panel.add(&path);
    if scene.truth().is_some() {
        let dash = r#"<path class="truth" d="M-12 0H12"/>"#.to_owned();
        panel.legend(&[(dash, "true onset of instability")]);
    }
    let alt = if low <= high {
        format!(
            "Signal against time, {} long, between {} and {} input units. {}",
            seconds(scene.t_end - scene.t_start),
            significant(low),
            significant(high),
            scene.spans_in_words()
        )
    } else {
        "Signal against time: there are no samples.".into()
    };
    panel.finish(
        &alt,
        "The samples as they came in; each pixel column reaches from the smallest to the \
         largest sample in it. The shaded span under a bar is an alarm, in every picture.",
    )
}

fn columns() -> usize {
    (RIGHT - LEFT) as usize
}

/// One sample, one vertex.
fn line(samples: &[f64], scene: &Scene<'_>, x: &Axis, y: &Axis) -> String {
    let mut d = String::new();
    let mut pen = 'M';
    let start = scene.job.sound.start_s();
    for (i, v) in samples.iter().enumerate() {
        if !v.is_finite() {
            pen = 'M';
            continue;
        }
        put!(
            d,
            "{pen}{} {}",
            px(x.at(start + i as f64 / scene.fs)),
            px(y.at(*v))
        );
        pen = 'L';
    }
    format!(r#"<path class="wave" d="{d}"/>"#)
}

/// A closed outline, one column per pixel; gaps where nothing is finite.
fn envelope(scene: &Scene<'_>, x: &Axis, y: &Axis) -> String {
    let mut d = String::new();
    let samples = scene.job.sound.samples();
    let per_column = samples as f64 / columns() as f64;
    let start = scene.job.sound.start_s();
    for column in 0..columns() {
        let from = (column as f64 * per_column) as u64;
        let to = (((column + 1) as f64 * per_column) as u64).min(samples);
        let Some((low, high)) = scene.job.sound.between(from, to) else {
            continue;
        };
        let (bottom, top) = (y.at(low), y.at(high));
        put!(
            d,
            "M{} {}V{}",
            px(x.at(start + 0.5 * (from + to) as f64 / scene.fs)),
            px(bottom.max(top + 0.8)),
            px(top)
        );
    }
    format!(r#"<path class="envelope" d="{d}"/>"#)
}
