//! A series through the conditioning of the monitor: offset, decimation to a band, its
//! high-pass. The one place where the host does so.

use rarma_core::condition::{Band, BandError, BandFilter};

/// What is left of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Banded {
    /// Samples at the reduced rate.
    pub samples: Vec<f64>,
    /// That rate, Hz.
    pub fs: f64,
    /// Delay of the decimation, s.
    pub delay_s: f64,
    /// The filters' own beginning, samples at the reduced rate.
    pub settle: usize,
}

/// `x` of rate `fs`, Hz, reduced to `band`.
///
/// # Errors
/// The band does not fit the rate.
pub fn through(x: &[f64], fs: f64, band: Band) -> Result<Banded, BandError> {
    let mut filter = BandFilter::new(band, fs)?;
    let samples = x.iter().filter_map(|x| filter.process(*x)).collect();
    let rate = fs / filter.factor() as f64;
    Ok(Banded {
        samples,
        fs: rate,
        delay_s: filter.delay_s(),
        settle: (filter.settle_s(band) * rate).ceil() as usize,
    })
}
