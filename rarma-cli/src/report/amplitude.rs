//! Picture (f): how the squared amplitude of the followed mode is distributed.

use super::Scene;
use super::course::Shown;
use crate::record::Amplitude;
use rarma_core::decide::{BINS_REACH, LIMIT_SCINTILLATION, SUSPICIOUS_SCINTILLATION};
use rarma_pictures::put;
use rarma_pictures::text::{count, escape, hertz, px, seconds, significant};
use rarma_pictures::{Axis, grid};
use rarma_pictures::{LEFT, TOP};

const WIDTH: f64 = 1000.0;
const HEIGHT: f64 = 190.0;
/// Right edge of the plot; words stand to the right of it.
const EDGE: f64 = 560.0;
const WORDS: f64 = 592.0;
const LINE: f64 = 20.0;

/// A verdict in a word.
pub(super) fn word(verdict: Amplitude) -> &'static str {
    match verdict {
        Amplitude::TooShort => "too short to tell",
        Amplitude::Forced => "noise on a damped mode",
        Amplitude::Suspicious => "steadier than noise",
        Amplitude::SelfExcited => "limit cycle",
        Amplitude::NotStationary => "not stationary",
    }
}

/// A verdict in a sentence that is broken in two lines.
fn sentence(verdict: Amplitude) -> [&'static str; 2] {
    match verdict {
        Amplitude::TooShort => ["Too few independent values", "for a verdict."],
        Amplitude::Forced => [
            "As of a damped mode that noise drives:",
            "not self-excited.",
        ],
        Amplitude::Suspicious => ["Steadier than noise by itself,", "but not beyond doubt."],
        Amplitude::SelfExcited => ["A limit cycle: the vibration", "sustains itself."],
        Amplitude::NotStationary => ["Not stationary: it grows, fades,", "or comes and goes."],
    }
}

/// Draws the figure.
pub(super) fn figure(scene: &Scene<'_>) -> String {
    let bottom = TOP + HEIGHT;
    let mut svg = format!(
        r#"<text x="{LEFT}" y="{}" class="title">(f) Amplitude of one mode</text>"#,
        px(TOP - 11.0)
    );
    let first = scene.spans.first().map(|span| span.f);
    let (alt, caption) = match scene.job.course.shown(first) {
        Some(shown) => draw(&mut svg, shown, bottom),
        None => {
            put!(
                svg,
                r#"<text x="{}" y="{}" class="name" text-anchor="middle">no mode was followed for long enough</text>"#,
                px(0.5 * (LEFT + EDGE)),
                px(0.5 * (TOP + bottom))
            );
            (
                "Distribution of the amplitude: none.".to_owned(),
                "Left empty: no mode was followed for long enough.".to_owned(),
            )
        }
    };
    put!(
        svg,
        r#"<rect class="frame" x="{LEFT}" y="{TOP}" width="{}" height="{HEIGHT}"/>"#,
        px(EDGE - LEFT)
    );
    format!(
        "<figure><div class=\"scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\">{svg}</svg></div><figcaption>{}</figcaption></figure>\n",
        px(bottom + 42.0),
        escape(&alt),
        escape(&caption)
    )
}

fn draw(svg: &mut String, shown: &Shown, bottom: f64) -> (String, String) {
    let histogram = &shown.histogram;
    let counts = &histogram.counts;
    let fit = counts.decreasing();
    let total = f64::from(counts.total());
    let percent = |n: f64| 100.0 * n / total;
    let most = counts.counts.iter().copied().max().unwrap_or(1);
    let x = Axis::linear(0.0, BINS_REACH, LEFT, EDGE);
    let y = Axis::linear(0.0, 1.08 * percent(f64::from(most)).max(1.0), bottom, TOP);
    grid(svg, (&x, 4), (&y, 4));
    let width = BINS_REACH / counts.counts.len() as f64;
    let (mut bars, mut steps) = (String::new(), String::new());
    for (k, (&n, &fitted)) in counts.counts.iter().zip(&fit.counts).enumerate() {
        let (left, right) = (x.at(k as f64 * width), x.at((k + 1) as f64 * width));
        put!(
            bars,
            "M{} {}V{}H{}V{}Z",
            px(left + 1.0),
            px(bottom),
            px(y.at(percent(f64::from(n)))),
            px(right - 1.0),
            px(bottom)
        );
        put!(
            steps,
            "{}{} {}H{}",
            if k == 0 { 'M' } else { 'L' },
            px(left),
            px(y.at(percent(fitted))),
            px(right)
        );
    }
    put!(
        svg,
        r#"<path class="struct" d="{bars}"/><path class="fit-case" d="{steps}"/><path class="fit" d="{steps}"/><text class="name" x="{}" y="{}" text-anchor="middle">squared amplitude V, in multiples of its mean before</text><text class="name" text-anchor="middle" transform="translate(18 {}) rotate(-90)">part of the time (%)</text>"#,
        px(0.5 * (LEFT + EDGE)),
        px(bottom + 36.0),
        px(0.5 * (TOP + bottom))
    );
    let mut words = vec![
        (
            "strong",
            format!(
                "Mode at {}, at {}",
                hertz(histogram.f),
                seconds(histogram.t)
            ),
        ),
        (
            "legend",
            format!(
                "{} values of V, {} of them beyond",
                count(u64::from(counts.total())),
                count(u64::from(counts.beyond))
            ),
        ),
    ];
    let mut spoken = String::new();
    if let Some(reading) = &shown.reading {
        let s = format!("S = Var V / (mean V)² = {}", significant(reading.s));
        let z = format!("{} sd from that of noise", significant(reading.z));
        spoken = format!(" {s}: {}.", word(reading.verdict));
        words.push(("strong", s));
        words.push(("legend", z));
        words.extend(sentence(reading.verdict).map(|w| ("strong", w.to_owned())));
    }
    words.push((
        "legend",
        format!(
            "{} % of the values would have to move",
            significant(100.0 * fit.weight)
        ),
    ));
    words.push(("legend", "for w(V) to fall everywhere.".to_owned()));
    for (k, (class, text)) in words.iter().enumerate() {
        put!(
            svg,
            r#"<text x="{WORDS}" y="{}" class="{class}">{}</text>"#,
            px(TOP + 14.0 + LINE * k as f64),
            escape(text)
        );
    }
    (
        format!(
            "Histogram of the squared amplitude of the mode at {} and the nearest falling step \
             function.{spoken}",
            hertz(histogram.f)
        ),
        format!(
            "Bars: how often the squared amplitude V of the mode had which value, w(V). Line: the \
             falling function nearest to it. Noise on a damped mode gives a w(V) that falls \
             everywhere and S = 1; a vibration that sustains itself has a preferred amplitude, a \
             hump away from 0, and S near 0. S below {LIMIT_SCINTILLATION:.2} is called a limit \
             cycle, below {SUSPICIOUS_SCINTILLATION} suspicious, if chance is excluded. It \
             confirms, it never raises the alarm: a steady forced line looks the same."
        ),
    )
}
