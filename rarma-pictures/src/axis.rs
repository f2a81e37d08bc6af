//! From values to pixels, and where the ticks go.

use super::text::px;

/// One axis: values `lo..hi` lie on pixels `from..to`.
#[derive(Debug, Clone, Copy)]
pub struct Axis {
    lo: f64,
    hi: f64,
    from: f64,
    to: f64,
    log: bool,
}

impl Axis {
    /// A linear axis; an empty or broken range becomes `lo..lo + 1`.
    pub fn linear(lo: f64, hi: f64, from: f64, to: f64) -> Self {
        let lo = if lo.is_finite() { lo } else { 0.0 };
        let hi = if hi.is_finite() && hi > lo {
            hi
        } else {
            lo + 1.0
        };
        Self {
            lo,
            hi,
            from,
            to,
            log: false,
        }
    }

    /// A logarithmic axis; both ends positive.
    pub fn log(lo: f64, hi: f64, from: f64, to: f64) -> Self {
        Self {
            lo,
            hi,
            from,
            to,
            log: true,
        }
    }

    /// Upper end.
    pub fn hi(&self) -> f64 {
        self.hi
    }

    /// Lower end.
    pub fn lo(&self) -> f64 {
        self.lo
    }

    /// Whether a value lies on the axis; NaN does not.
    pub fn holds(&self, value: f64) -> bool {
        value >= self.lo && value <= self.hi
    }

    /// Pixel of a value, which is first brought into the range.
    pub fn at(&self, value: f64) -> f64 {
        let value = if value.is_nan() { self.lo } else { value };
        let value = value.clamp(self.lo, self.hi);
        let share = if self.log {
            (value / self.lo).ln() / (self.hi / self.lo).ln()
        } else {
            (value - self.lo) / (self.hi - self.lo)
        };
        self.from + share * (self.to - self.from)
    }

    /// Pixel of a value, outside the axis as well. What has no logarithm lies far below.
    pub fn beyond(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.max(1e-6 * self.lo) / self.lo).ln() / (self.hi / self.lo).ln()
        } else {
            (value - self.lo) / (self.hi - self.lo)
        };
        self.from + share * (self.to - self.from)
    }

    /// About `wanted` round values with their labels.
    pub fn ticks(&self, wanted: usize) -> Vec<(f64, String)> {
        if self.log {
            return self.decades();
        }
        let rough = (self.hi - self.lo) / wanted.max(1) as f64;
        let power = 10_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .map(|m| m * power)
            .find(|step| *step >= rough * 0.999)
            .unwrap_or(10.0 * power);
        let decimals = (-step.log10().floor()).clamp(0.0, 9.0) as usize;
        let first = (self.lo / step - 1e-9).ceil();
        let last = (self.hi / step + 1e-9).floor();
        let many = ((last - first).max(0.0) as usize).min(50);
        (0..=many)
            .map(|i| {
                let value = (first + i as f64) * step + 0.0;
                let label = if !(1e-6..1e7).contains(&step) {
                    format!("{value:.1e}")
                } else {
                    format!("{value:.decimals$}")
                };
                (value, label.replace('-', "−"))
            })
            .collect()
    }

    fn decades(&self) -> Vec<(f64, String)> {
        // Those within: one beyond an end would be drawn at that end.
        let within = |steps: &[f64]| -> Vec<(f64, String)> {
            let (first, last) = (self.lo.log10().floor(), self.hi.log10().ceil());
            (first as i32..=last as i32)
                .flat_map(|e| steps.iter().map(move |step| step * 10_f64.powi(e)))
                .filter(|v| *v > self.lo * (1.0 - 1e-9) && *v < self.hi * (1.0 + 1e-9))
                .map(|v| (v, format!("{v}")))
                .collect()
        };
        let decades = within(&[1.0]);
        if decades.len() < 2 {
            // Less than two decades: one number would not tell how far they go.
            return within(&[1.0, 2.0, 5.0]);
        }
        decades
    }

    /// Two to nine times each decade of a logarithmic axis.
    pub fn between_decades(&self) -> Vec<f64> {
        let (first, last) = (self.lo.log10().floor(), self.hi.log10().ceil());
        (first as i32..=last as i32)
            .flat_map(|e| (2..10).map(move |k| f64::from(k) * 10_f64.powi(e)))
            .filter(|v| self.holds(*v))
            .collect()
    }
}

/// Lines across the plot at about so many values of `y`, ticks below it at about so many
/// of `x`, each with its number.
pub fn grid(svg: &mut String, (x, along): (&Axis, usize), (y, up): (&Axis, usize)) {
    let (left, right, bottom) = (x.from, x.to, y.from);
    for (value, label) in y.ticks(up) {
        let at = px(y.at(value));
        put!(
            svg,
            r#"<path class="grid" d="M{left} {at}H{right}"/><text x="{}" y="{}" class="number" text-anchor="end">{label}</text>"#,
            px(left - 8.0),
            px(y.at(value) + 4.0)
        );
    }
    for (value, label) in x.ticks(along) {
        let at = px(x.at(value));
        put!(
            svg,
            r#"<path class="tick" d="M{at} {}v5"/><text x="{at}" y="{}" class="number" text-anchor="middle">{label}</text>"#,
            px(bottom),
            px(bottom + 18.0)
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: Axis, n: usize) -> Vec<String> {
        axis.ticks(n).into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn ticks_are_round() {
        assert_eq!(
            labels(Axis::linear(0.0, 16.0, 0.0, 1.0), 8),
            ["0", "2", "4", "6", "8", "10", "12", "14", "16"]
        );
        assert_eq!(
            labels(Axis::linear(-0.25, 0.25, 0.0, 1.0), 5),
            ["−0.2", "−0.1", "0.0", "0.1", "0.2"]
        );
        assert_eq!(
            labels(Axis::log(0.01, 100.0, 0.0, 1.0), 0),
            ["0.01", "0.1", "1", "10", "100"]
        );
        // Nothing beyond an end, and something on a short one.
        assert_eq!(
            labels(Axis::log(0.5, 5000.0, 0.0, 1.0), 0),
            ["1", "10", "100", "1000"]
        );
        assert_eq!(labels(Axis::log(3.0, 30.0, 0.0, 1.0), 0), ["5", "10", "20"]);
    }

    #[test]
    fn every_value_has_a_pixel_inside() {
        let axis = Axis::log(0.01, 100.0, 200.0, 0.0);
        for v in [f64::NAN, -1.0, 0.0, 1e-9, 1.0, 1e9, f64::INFINITY] {
            assert!((0.0..=200.0).contains(&axis.at(v)), "{v}");
        }
        assert!((axis.at(1.0) - 100.0).abs() < 1e-9);
        let broken = Axis::linear(f64::NAN, f64::NEG_INFINITY, 0.0, 1.0);
        assert!(broken.at(0.5).is_finite() && broken.ticks(5).len() > 1);
    }
}
