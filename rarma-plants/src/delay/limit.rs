//! Limits of stability by semi-discretisation.

use super::roots::Crossing;
use super::{DelaySystem, Root};
use crate::error::{PlantError, positive, require};
use core::cell::Cell;

/// Where to look for a limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthSearch {
    /// Depth at which the scan starts, m, > 0; halved until the cut is stable there.
    pub low_m: f64,
    /// Largest depth, m, finite.
    pub high_m: f64,
    /// Ratio of one depth of the upward scan to the one before, > 1. Unstable
    /// islands narrower than this are not seen.
    pub ratio: f64,
    /// Width of the final bracket relative to the depth.
    pub tolerance: f64,
}

impl DepthSearch {
    /// From `low_m` to `high_m` in steps of 6 %, to 1e-5.
    #[must_use]
    pub fn between(low_m: f64, high_m: f64) -> Self {
        Self {
            low_m,
            high_m,
            ratio: 1.06,
            tolerance: 1e-5,
        }
    }
}

/// A point on the stability border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Border {
    /// Limit depth (milling) or width (turning), m.
    pub depth_m: f64,
    /// How stability is lost there.
    pub crossing: Crossing,
    /// The root that crosses: its frequency is the chatter frequency.
    pub root: Root,
}

/// Lowest depth at which the cut that `at` builds becomes unstable.
///
/// # Errors
/// `NoLimit` if every depth of the scan up to `high_m` is stable, or none is, however
/// small; `GivenUp` if the search takes more than `MOST_WORK`; `Unsettled` if it cannot
/// be told whether a depth is stable; else what `at` gives.
pub fn limit(
    search: &DepthSearch,
    at: impl Fn(f64) -> Result<DelaySystem, PlantError>,
) -> Result<Border, PlantError> {
    let spent = Cell::new(0.0);
    let depth_m = limit_by(search, |b| {
        if spent.get() > MOST_WORK {
            return Err(PlantError::GivenUp);
        }
        let (radius, work) = at(b)?.radius_and_work();
        spent.set(spent.get() + work);
        Ok(radius)
    })?;
    let system = at(depth_m)?;
    let root = *system.roots(1).first().ok_or(PlantError::Unsettled)?;
    let (re, im) = root.multiplier;
    Ok(Border {
        depth_m,
        crossing: Crossing::of(re, im),
        root,
    })
}

/// Multiplications after which a search is given up: half a minute or so.
pub const MOST_WORK: f64 = 3e10;

/// Depths that are looked at before a search is given up.
const MOST_LOOKS: u32 = 1000;

/// A cut that is unstable at this part of the depth the scan starts at is so at any.
const LEAST_PART: f64 = 1e-9;

/// Lowest depth at which `radius` passes 1, by an upward scan and regula falsi
/// (Illinois) on radius - 1, which is smooth there.
///
/// # Errors
/// As [`limit`].
pub fn limit_by(
    search: &DepthSearch,
    radius: impl Fn(f64) -> Result<f64, PlantError>,
) -> Result<f64, PlantError> {
    positive(search.low_m, "low_m")?;
    require(search.high_m.is_finite(), "high_m")?;
    require(search.ratio > 1.0, "ratio")?;
    require(search.tolerance > 0.0, "tolerance")?;
    let looks = Cell::new(0);
    let excess = |b: f64| {
        looks.set(looks.get() + 1);
        if looks.get() > MOST_LOOKS {
            return Err(PlantError::GivenUp);
        }
        let radius = radius(b)?;
        if radius.is_nan() {
            return Err(PlantError::Unsettled);
        }
        Ok(radius - 1.0)
    };
    let (mut low, mut at_low) = (search.low_m, excess(search.low_m)?);
    while at_low >= 0.0 {
        low *= 0.5;
        if low < LEAST_PART * search.low_m {
            return Err(PlantError::NoLimit);
        }
        at_low = excess(low)?;
    }
    let (mut high, mut at_high);
    loop {
        if low >= search.high_m {
            return Err(PlantError::NoLimit);
        }
        high = (low * search.ratio).min(search.high_m);
        at_high = excess(high)?;
        if at_high >= 0.0 {
            break;
        }
        (low, at_low) = (high, at_high);
    }
    let (mut weight_low, mut weight_high) = (at_low, at_high);
    for _ in 0..60 {
        if high - low <= search.tolerance * high {
            break;
        }
        let mut middle = (low * weight_high - high * weight_low) / (weight_high - weight_low);
        if !middle.is_finite() {
            // An infinite radius says on which side, not how far.
            middle = 0.5 * (low + high);
        }
        // Never closer to an end than the tolerance: else the other never moves.
        let edge = 0.3 * search.tolerance * high;
        middle = middle.clamp(low + edge, high - edge);
        let value = excess(middle)?;
        if value < 0.0 {
            low = middle;
            weight_low = value;
            weight_high *= 0.5;
        } else {
            high = middle;
            weight_high = value;
            weight_low *= 0.5;
        }
    }
    Ok(0.5 * (low + high))
}
