//! Table 3 of the thesis, both of its columns.
//!
//! The table's columns are interleaved in the text at hand: which number belongs to which
//! is our reading, by the nearest frequency for the parametric ones.

use serde::Serialize;

/// A mode of the table: by experimental modal analysis and by the batch ARMA model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Printed {
    /// Modal analysis: frequency Hz and damping ratio.
    pub ema: (f64, f64),
    /// ARMA model: the same; none where the table has no value for this mode.
    pub para: Option<(f64, f64)>,
}

const fn row(f: f64, zeta: f64, para: Option<(f64, f64)>) -> Printed {
    Printed {
        ema: (f, zeta),
        para,
    }
}

/// Direction x.
pub const X: [Printed; 7] = [
    row(390.0, 0.033, Some((400.0, 0.042))),
    row(531.0, 0.032, Some((502.0, 0.051))),
    row(807.0, 0.071, Some((820.0, 0.061))),
    row(932.0, 0.059, Some((1020.0, 0.042))),
    row(1710.0, 0.059, Some((1690.0, 0.059))),
    row(2160.0, 0.048, None),
    row(2315.0, 0.028, Some((2330.0, 0.037))),
];

/// Direction y. The parametric column also has 1747 Hz, 5.4 %, which no mode of the other
/// is near.
pub const Y: [Printed; 5] = [
    row(502.0, 0.046, Some((512.0, 0.046))),
    row(800.0, 0.042, Some((800.0, 0.036))),
    row(974.0, 0.070, Some((970.0, 0.047))),
    row(1240.0, 0.072, None),
    row(2280.0, 0.050, Some((2237.0, 0.031))),
];

/// The row of a direction nearest to a frequency, within a fortieth.
pub fn nearest(axis: usize, f_hz: f64) -> Option<Printed> {
    let rows: &[Printed] = if axis == 0 { &X } else { &Y };
    rows.iter()
        .copied()
        .min_by(|a, b| (a.ema.0 - f_hz).abs().total_cmp(&(b.ema.0 - f_hz).abs()))
        .filter(|p| (p.ema.0 / f_hz - 1.0).abs() < 0.025)
}
