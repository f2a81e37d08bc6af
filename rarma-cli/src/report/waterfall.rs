//! Picture (b): how strong which frequency is when.

use super::sound::{ROWS, SHORTEST, hann, mean, window};
use super::{Scene, Sound, multiples};
use rarma_pictures::Axis;
use rarma_pictures::text::{hertz, px, seconds, significant};
use rarma_pictures::{LEFT, Panel, RIGHT, TOP};
use rarma_pictures::{SHADES, bitmap, gradient_stops};

const HEIGHT: f64 = 260.0;
const COLUMNS: usize = 720;

/// Levels in dB on a grid of pixels.
struct Grid {
    /// Window length, samples.
    window: usize,
    /// Row by row from the highest frequency, dB.
    level: Vec<f64>,
    low: f64,
    high: f64,
}

/// Draws the figure.
pub(super) fn figure(scene: &Scene<'_>) -> String {
    let mut panel = scene.panel(HEIGHT, "(b) Waterfall");
    let y = Axis::linear(0.0, scene.f_top, panel.bottom, TOP);
    panel.axes(&y, 5, "frequency (Hz)");
    let grid = analyse(scene);
    let (alt, mut caption) = match &grid {
        Some(grid) => {
            draw(&mut panel, scene, grid);
            (
                format!(
                    "Spectrogram: level from {} to {} dB against time and frequency \
                     up to {}. {}",
                    significant(grid.low),
                    significant(grid.high),
                    hertz(scene.f_top),
                    scene.spans_in_words()
                ),
                format!(
                    "Level of each frequency, in dB relative to an amplitude of one input unit; \
                     Hann window of {}, so that lines closer than {} merge. Dashed: edges of the \
                     band that is analysed; a mark at the right edge: frequency of an alarm.",
                    seconds(grid.window as f64 / scene.fs),
                    hertz(2.0 * scene.fs / grid.window as f64)
                ),
            )
        }
        None => {
            let middle = 0.5 * (TOP + panel.bottom);
            let words = "too few samples for a spectrum";
            panel.label(0.5 * (LEFT + RIGHT), middle, "name", "middle", words);
            (
                "Spectrogram: too few samples.".to_owned(),
                "Left empty: the recording is shorter than the shortest window.".to_owned(),
            )
        }
    };
    if grid.is_some()
        && let Some(drawn) = multiples::draw(&mut panel, scene, &y, "multiple", None)
    {
        caption.push_str(&drawn.caption);
        caption.push_str(&blind(scene));
    }
    scene.band_edges(&mut panel, &y, "over");
    scene.alarm_marks(&mut panel, &y);
    panel.finish(&alt, &caption)
}

/// What removing the multiples costs, in words.
fn blind(scene: &Scene<'_>) -> String {
    let spindle = &scene.job.summary.spindle;
    match spindle.notch_hz.filter(|f| f.is_finite() && *f > 0.0) {
        Some(notch) => format!(
            " They were followed and removed for {}; within {} either side of each, nothing \
             can be heard then.",
            seconds(spindle.locked_s),
            hertz(notch)
        ),
        None => " They were not removed.".to_owned(),
    }
}

fn draw(panel: &mut Panel<'_>, scene: &Scene<'_>, grid: &Grid) {
    let span = grid.high - grid.low;
    let shades: Vec<u8> = grid
        .level
        .iter()
        .map(|v| (((v - grid.low) / span).clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as u8)
        .collect();
    if let Some(data) = bitmap(COLUMNS, ROWS, &shades) {
        let sound = scene.job.sound;
        let start_s = sound.start_s();
        let start = panel.x.at(start_s);
        let end = panel.x.at(start_s + sound.samples() as f64 / scene.fs);
        panel.add(&format!(
            "<image class=\"inks\" x=\"{}\" y=\"{TOP}\" width=\"{}\" height=\"{HEIGHT}\" \
             preserveAspectRatio=\"none\" aria-hidden=\"true\" href=\"{data}\"/>",
            px(start),
            px(end - start)
        ));
    }
    let (x, y) = (RIGHT - 210.0, TOP - 21.0);
    panel.add(&format!(
        "<defs><linearGradient id=\"level\">{}</linearGradient></defs>\
         <rect class=\"inks\" fill=\"url(#level)\" x=\"{x}\" y=\"{y}\" width=\"130\" height=\"11\"/>\
         <rect class=\"frame\" x=\"{x}\" y=\"{y}\" width=\"130\" height=\"11\"/>",
        gradient_stops()
    ));
    let words = |v: f64| format!("{v:.0}").replace('-', "−");
    panel.label(x - 7.0, TOP - 11.0, "legend", "end", &words(grid.low));
    panel.label(
        x + 137.0,
        TOP - 11.0,
        "legend",
        "start",
        &format!("{} dB", words(grid.high)),
    );
}

/// Short-time spectra, averaged where a pixel column holds more than one
/// window; `None` if there is not even one window of samples.
fn analyse(scene: &Scene<'_>) -> Option<Grid> {
    let (window, power) = match scene.job.sound.whole() {
        Some(samples) => of_whole(samples, scene)?,
        None => of_long(scene.job.sound)?,
    };
    let mut level = vec![0.0; COLUMNS * ROWS];
    let edge = |r: usize| r as f64 / ROWS as f64 * scene.f_top * window as f64 / scene.fs;
    for (column, power) in power.iter().enumerate() {
        for row in 0..ROWS {
            level[(ROWS - 1 - row) * COLUMNS + column] = pick(power, edge(row), edge(row + 1));
        }
    }
    let (low, high) = range(&level)?;
    Some(Grid {
        window,
        level,
        low,
        high,
    })
}

/// Window, and mean power at every frequency of it, column by column.
type Spectra = (usize, Vec<Vec<f64>>);

/// Of a recording whose samples are all kept.
fn of_whole(samples: &[f64], scene: &Scene<'_>) -> Option<Spectra> {
    let longest = (samples.len() / 8).max(SHORTEST);
    let window = window(scene.fs, scene.f_top, longest);
    if samples.len() < window || window < SHORTEST {
        return None;
    }
    let (hann, gain) = hann(window);
    let mean = mean(samples);
    let fft = rarma_fourier::forward(window);
    let (mut input, mut output) = (fft.make_input_vec(), fft.make_output_vec());
    let per_column = samples.len() as f64 / COLUMNS as f64;
    let pieces = ((per_column / window as f64).ceil() as usize).clamp(1, 4);
    let mut all = Vec::with_capacity(COLUMNS);
    for column in 0..COLUMNS {
        let mut power = vec![0.0; output.len()];
        for piece in 0..pieces {
            let within = (piece as f64 + 0.5) / pieces as f64;
            let centre = (column as f64 + within) * per_column;
            let start = (centre as usize)
                .saturating_sub(window / 2)
                .min(samples.len() - window);
            for (slot, (v, w)) in input.iter_mut().zip(samples[start..].iter().zip(&hann)) {
                *slot = if v.is_finite() { (v - mean) * w } else { 0.0 };
            }
            fft.process(&mut input, &mut output).ok()?;
            for (sum, bin) in power.iter_mut().zip(&output) {
                *sum += bin.norm_sqr() * gain * gain / pieces as f64;
            }
        }
        all.push(power);
    }
    Some((window, all))
}

/// Of one that was analysed as it came.
fn of_long(sound: &Sound) -> Option<Spectra> {
    let samples = sound.samples();
    let at = |column: usize| (column as f64 / COLUMNS as f64 * samples as f64) as u64;
    let (window, _) = sound.spectrum(0, 0)?;
    let column = |c| Some(sound.spectrum(at(c), at(c + 1))?.1);
    Some((window, (0..COLUMNS).map(column).collect::<Option<_>>()?))
}

/// Level in dB of the bins between two places: the strongest of them, or, where
/// there is none, a straight line between the neighbours.
fn pick(power: &[f64], from: f64, to: f64) -> f64 {
    let db = |p: f64| 10.0 * p.max(1e-30).log10();
    let last = power.len() - 1;
    let (first, end) = (from.ceil() as usize, to.ceil() as usize);
    if first < end && first <= last {
        let most = power[first..end.min(last + 1)]
            .iter()
            .copied()
            .fold(0.0, f64::max);
        return db(most);
    }
    let middle = (0.5 * (from + to)).min(last as f64);
    let below = (middle as usize).min(last);
    let above = (below + 1).min(last);
    let share = middle - below as f64;
    db(power[below]) * (1.0 - share) + db(power[above]) * share
}

/// From the quiet twentieth to the loudest pixel, 30 to 80 dB apart, to whole
/// tens outwards. `None` if nothing was heard at all.
fn range(level: &[f64]) -> Option<(f64, f64)> {
    let mut sorted: Vec<f64> = level.to_vec();
    sorted.sort_by(f64::total_cmp);
    let high = *sorted.last()?;
    if high <= -290.0 {
        return None;
    }
    let quiet = sorted[sorted.len() / 20];
    let low = quiet.clamp(high - 80.0, high - 30.0);
    Some((low.floor(), high.ceil()))
}
