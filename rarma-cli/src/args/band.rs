//! The band of a recording that `identify`, `order` and `psd` look at.

use super::band;
use clap::Args;
use rarma_core::condition::Band;

/// What part of a recording is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BandChoice {
    /// This band, through the monitor's conditioning.
    Of(Band),
    /// Everything, sample by sample as it is.
    Full,
}

/// The option that says so.
#[derive(Debug, Clone, Copy, Args)]
pub struct BandArgs {
    /// Band in Hz that is looked at, decimated as the monitor does, or `full` for the
    /// recording as it is [default: the monitor's band above 6 kHz, else full].
    #[arg(long, value_name = "LO:HI|full", value_parser = choice)]
    pub band: Option<BandChoice>,
}

/// Up to this rate a recording is taken as it is unless a band is asked for, Hz: the
/// monitor's usual band starts to reduce the rate above it.
pub const FULL_UP_TO_HZ: f64 = 6000.0;

impl BandArgs {
    /// The band for a recording of rate `fs`, Hz; none for all of it.
    pub fn of(self, fs: f64) -> Option<Band> {
        match self.band {
            Some(BandChoice::Of(band)) => Some(band),
            Some(BandChoice::Full) => None,
            None => (fs > FULL_UP_TO_HZ).then(|| Band::usual(fs)),
        }
    }
}

fn choice(text: &str) -> Result<BandChoice, String> {
    if text.trim() == "full" {
        return Ok(BandChoice::Full);
    }
    band(text)
        .map(BandChoice::Of)
        .map_err(|why| format!("{why}, or be `full`"))
}
