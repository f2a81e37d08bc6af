//! What the box does with every sample, in single precision.
//!
//! Generic code is made in the crate that names its types, at that crate's level of
//! optimisation. Made here, it is made for speed, while the rest of an image may be made
//! for size (profile `fw-small`).
#![no_std]

use core::slice::Iter;
use rarma_core::monitor::{Monitor, Report};

/// [`Monitor::push_row`].
#[inline(never)]
pub fn push(monitor: &mut Monitor<f32>, samples: &mut Iter<'_, f32>) -> Option<Report<f32>> {
    monitor.push_row(samples)
}
