//! Pictures of models of a whole recording: poles over orders, the density of a model over the
//! estimate, what the residuals still hold.

use rarma_pictures::{Chart, Mark, Scale, Series};

/// Deviations either way of a bar that holds the truth with 95 %.
pub(super) const BAR: f64 = 1.96;
const NOT: (f64, f64) = (f64::NAN, f64::NAN);

/// A pole of a diagram over orders.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiagramPole {
    /// Height in the diagram.
    pub row: f64,
    /// Hz.
    pub f: f64,
    /// Standard deviation of it, Hz; NaN where there is none.
    pub f_sd: f64,
    /// The same in frequency and damping as one a step below.
    pub stable: bool,
    /// In frequency alone.
    pub stable_f: bool,
    /// It belongs to the model that was chosen.
    pub chosen: bool,
}

/// Poles over orders, over the estimate of the density as a backdrop; `columns` are the frequencies
/// that orders agree on, Hz, an upright line each.
pub(super) fn diagram(
    poles: &[DiagramPole],
    columns: &[f64],
    density: &[(f64, f64)],
    edges: (f64, f64),
    rows: &str,
    what_is_stable: &str,
) -> String {
    let top = poles.iter().fold(2.0f64, |m, p| m.max(p.row)) + 1.0;
    let of = |keep: &dyn Fn(&DiagramPole) -> bool| -> Vec<(f64, f64)> {
        let those = poles.iter().filter(|p| keep(p));
        those.map(|p| (p.f, p.row)).collect()
    };
    let bars = poles
        .iter()
        .filter(|p| p.stable && p.f_sd.is_finite())
        .flat_map(|p| {
            let reach = BAR * p.f_sd;
            [(p.f - reach, p.row), (p.f + reach, p.row), NOT]
        })
        .map(|(f, row)| (f.clamp(edges.0, edges.1), row))
        .collect();
    let levels = decibels(density);
    let (low, high) = range(levels.iter().map(|p| p.1));
    let backdrop = levels
        .iter()
        .map(|(f, level)| (*f, 0.92 * top * (level - low) / (high - low).max(1.0)))
        .collect();
    let columns: Vec<(f64, f64)> = columns
        .iter()
        .flat_map(|f| [(*f, 0.0), (*f, top), NOT])
        .collect();
    // The legend names only what is there.
    let agreed = match columns.is_empty() {
        true => "",
        false => "column that orders agree on",
    };
    Chart {
        title: "Stabilisation diagram".to_owned(),
        x: Scale::linear("frequency (Hz)", edges.0, edges.1),
        y: Scale::linear(rows, 0.0, top),
        height: 380.0,
        series: vec![
            Series::new("density (its own scale)", backdrop, Mark::Below, 5),
            Series::new(agreed, columns, Mark::Dashes, 1),
            Series::new("", bars, Mark::Line, 0),
            Series::new("stable", of(&|p| p.stable), Mark::Dots, 0),
            Series::new(
                "stable in frequency alone",
                of(&|p| p.stable_f && !p.stable),
                Mark::Dots,
                4,
            ),
            Series::new("new", of(&|p| !p.stable_f), Mark::Dots, 5),
            Series::new("chosen", of(&|p| p.chosen), Mark::Place, 0),
        ],
        caption: format!(
            "Poles of the models of each order. {what_is_stable} Bars: 1.96 standard deviations of \
             the frequency either way, of those that are stable; most are narrower than the dot. A \
             mode of the structure is a column of stable poles; what a model makes up out of noise moves."
        ),
    }
    .figure()
}

/// The density of a model over the estimate without one.
pub(super) fn densities(
    estimate: &[(f64, f64)],
    model: &[(f64, f64)],
    edges: (f64, f64),
    order: [usize; 2],
) -> String {
    let (estimate, model) = (decibels(estimate), decibels(model));
    let (low, high) = range(estimate.iter().chain(&model).map(|p| p.1));
    Chart {
        title: "Power spectral density".to_owned(),
        x: Scale::linear("frequency (Hz)", edges.0, edges.1),
        y: Scale::linear("dB re (input unit)²/Hz", low - 2.0, high + 2.0),
        height: 300.0,
        series: vec![
            Series {
                name: "Welch's estimate".to_owned(),
                points: estimate,
                mark: Mark::Line,
                colour: 0,
            },
            Series {
                name: format!("ARMA({},{})", order[0], order[1]),
                points: model,
                mark: Mark::Dashes,
                colour: 1,
            },
        ],
        caption: "A peak of the estimate that the model passes by is one it lacks; a peak of the \
                  model alone is one it made up. Welch's estimate scatters by a few dB."
            .to_owned(),
    }
    .figure()
}

/// Autocorrelation of residuals with the band that white ones keep to.
pub(super) fn residuals(errors: &[f64], lags: usize, probability: Option<f64>) -> String {
    let power: f64 = errors.iter().map(|e| e * e).sum();
    let r = |k: usize| -> f64 {
        let product: f64 = errors.iter().zip(&errors[k..]).map(|(x, y)| x * y).sum();
        product / power
    };
    let lags = lags.min(errors.len().saturating_sub(1));
    let values: Vec<f64> = (1..=lags).map(r).collect();
    let band = BAR / (errors.len() as f64).sqrt();
    let most = values.iter().fold(2.0 * band, |m: f64, r| m.max(r.abs()));
    let sticks = values
        .iter()
        .enumerate()
        .flat_map(|(k, r)| [((k + 1) as f64, 0.0), ((k + 1) as f64, *r), NOT])
        .collect();
    let dots = values.iter().enumerate();
    let outside = values.iter().filter(|r| r.abs() > band).count();
    let level = |y: f64| Series {
        name: if y > 0.0 {
            "95 % of white residuals lie within".to_owned()
        } else {
            String::new()
        },
        points: vec![(0.0, y), (lags as f64 + 1.0, y)],
        mark: Mark::Dashes,
        colour: 5,
    };
    let said = match probability {
        Some(p) => {
            format!("Ljung-Box: residuals as coloured as these are white with probability {p:.3}.")
        }
        None => "Too few samples for the test of Ljung and Box.".to_owned(),
    };
    Chart {
        title: "Autocorrelation of the residuals".to_owned(),
        x: Scale::linear("lag (samples)", 0.0, lags as f64 + 1.0),
        y: Scale::linear("correlation", -1.1 * most, 1.1 * most),
        height: 180.0,
        series: vec![
            level(band),
            level(-band),
            Series {
                name: String::new(),
                points: sticks,
                mark: Mark::Line,
                colour: 0,
            },
            Series {
                name: "residuals".to_owned(),
                points: dots.map(|(k, r)| ((k + 1) as f64, *r)).collect(),
                mark: Mark::Dots,
                colour: 0,
            },
        ],
        caption: format!("{outside} of {lags} outside. {said}"),
    }
    .figure()
}

fn decibels(density: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let level = |s: f64| 10.0 * s.max(f64::MIN_POSITIVE).log10();
    density.iter().map(|(f, s)| (*f, level(*s))).collect()
}

/// Least and largest, no wider than 120: below that is rounding.
fn range(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let high = values.clone().fold(f64::NEG_INFINITY, f64::max);
    let low = values.fold(f64::INFINITY, f64::min);
    (low.max(high - 120.0), high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pole_is_in_the_diagram_once_by_what_became_of_it() {
        let pole = |row: f64, stable, stable_f| DiagramPole {
            row,
            f: 100.0 * row,
            f_sd: 1.0,
            stable,
            stable_f,
            chosen: stable,
        };
        let poles = [
            pole(2.0, false, false),
            pole(3.0, false, true),
            pole(4.0, true, true),
            pole(5.0, true, true),
        ];
        let density = [(0.0, 1.0), (500.0, 1e-3), (1000.0, 1e-6)];
        let html = diagram(
            &poles,
            &[450.0],
            &density,
            (0.0, 1000.0),
            "order",
            "Stable: so.",
        );
        let count = |class: &str| {
            let path = html.rsplit(&format!("{class}\" d=\"")).next().unwrap_or("");
            path.split('"').next().unwrap_or("").matches('M').count()
        };
        // Two rings are a ring and a cross each.
        assert_eq!(
            [
                count("dots c0"),
                count("dots c4"),
                count("dots c5"),
                count("place")
            ],
            [2, 1, 1, 6]
        );
        // One upright line over all of the height.
        assert_eq!(count("curve c1 dashed"), 1);
    }

    #[test]
    fn residuals_that_repeat_are_outside_of_the_band() {
        let mut seed = 1u32;
        let white: Vec<f64> = (0..4000)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed >> 8) / 8_388_608.0 - 1.0
            })
            .collect();
        let echo: Vec<f64> = (0..4000)
            .map(|t| white[t] + if t >= 7 { 0.5 * white[t - 7] } else { 0.0 })
            .collect();
        let html = residuals(&echo, 10, Some(0.0));
        let outside: usize = html
            .split("<figcaption>")
            .nth(1)
            .and_then(|c| c.split(' ').next())
            .and_then(|n| n.parse().ok())
            .expect("how many");
        assert!((1..=4).contains(&outside), "{outside}");
    }
}
