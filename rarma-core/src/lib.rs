//! Listening to machine tools: a recursive ARMA model of a cut's vibration, new at every sample,
//! and what it says of the machine's damping, on a microcontroller.
//!
//! No `std`, no allocation, no `unsafe`, no panic in the sample path; `f32` and `f64` from one
//! source. Frequencies are in Hz, times in s, damping ratios ζ as a part of one.
//!
//! ```text
//!            condition         estimate           spectrum           verdict, decide
//! samples ─▶ health, band, ─▶ A(q)y = C(q)e ─▶ roots of A ─▶ f, ζ ─▶ forced or self-excited?
//!            decimation,       new at each        and their          is damping being lost?
//!            rotation's lines  sample             uncertainty              │
//!                                                                          ▼
//!                      monitor: the four composed, one sample in ──▶ state, modes, alarm ─▶ advice, act
//! ```
//!
//! # From samples to frequency and damping
//!
//! ```
//! use rarma_core::prelude::*;
//!
//! let fs = 6000.0; // samples a second
//! let mut model = Arma21::<f64>::new(RarmaConfig::default());
//! let mut roots = FactorTracker::<f64, 2>::new();
//! # let mut seed = 1u32;
//! # let (mut y1, mut y2) = (0.0, 0.0);
//! # let mut samples = (0..60_000).map(|_| {
//! #     seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
//! #     let w = 2.0 * core::f64::consts::PI * 900.0 / fs;
//! #     let (r, angle) = ((-0.02 * w).exp(), w * (1.0f64 - 0.02 * 0.02).sqrt());
//! #     let y = 2.0 * r * angle.cos() * y1 - r * r * y2 + f64::from(seed >> 8) / 8_388_608.0 - 1.0;
//! #     (y2, y1) = (y1, y);
//! #     y
//! # });
//! for y in samples {
//!     model.update(y);          // a new model
//!     roots.track(model.a());   // and its poles
//! }
//! let pole = &roots.factors(2)[0];
//! let mode = modal(pole, fs).unwrap();
//! let sd = deviation(model.a(), 3, pole, fs, model.covariance(), model.covariance_factor()).unwrap();
//! // A mode of 900 Hz with ζ = 2 %, in ten seconds of sound:
//! assert!((mode.frequency - 900.0).abs() < 3.0 * sd.frequency && sd.frequency < 1.0);
//! assert!((mode.damping - 0.02).abs() < 3.0 * sd.damping && sd.damping < 0.001);
//! ```
//!
//! # From samples to a verdict
//!
//! [`Monitor`] is the whole chain; its example shows it. Choose the order by [`Order`] while the
//! program runs, or by the type ([`estimate::Arma43`]) where it is known beforehand.
//!
//! # Rooms
//!
//! | module | what |
//! |---|---|
//! | [`estimate`] | the recursive model and its start-up; of itself enough for a damping meter |
//! | [`spectrum`] | roots of a model that moves, poles to f and ζ with deviations, loudness of a mode |
//! | `condition` | health, band and decimation, lines of the rotation, tacho |
//! | `verdict` | which source made a line: rotation, background, a rung mode, the cut itself |
//! | `decide` | whether a mode loses its damping, and the alarm |
//! | `monitor` | all of it, one sample in, one or two sensors |
//! | `named` | the names of states, reasons, labels and sources in records |
//! | `advice`, `act` | which speed to turn instead, and when a controller may be told |
//!
//! Features: `monitor` (default) is everything but `estimate`, `spectrum` and [`real`]; `serde` lets
//! reports and settings be written; `defmt` (1.0) lets a firmware log what comes back: [`estimate::Status`],
//! [`spectrum::Modal`], `Report` with its states, modes and alarm events, faults, and every error. Fits of a whole recording are in `rarma-fit`.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

#[cfg(feature = "monitor")]
pub mod act;
#[cfg(feature = "monitor")]
pub mod advice;
#[cfg(feature = "monitor")]
pub mod condition;
#[cfg(feature = "monitor")]
pub mod decide;
pub mod estimate;
#[cfg(feature = "monitor")]
pub mod monitor;
#[cfg(feature = "monitor")]
pub mod named;
#[cfg(feature = "monitor")]
mod order;
pub mod prelude;
pub mod real;
pub mod spectrum;
mod ud;
#[cfg(feature = "monitor")]
pub mod verdict;
mod visit;
#[cfg(feature = "monitor")]
pub use monitor::Monitor;
#[cfg(feature = "monitor")]
pub use order::Order;
pub use real::Real;
pub use ud::UdFactors;

/// What a firmware can log, checked where it is built.
#[cfg(feature = "defmt")]
const _: () = {
    const fn logged<T: defmt::Format>() {}
    logged::<estimate::Status>();
    logged::<estimate::ConfigError>();
    logged::<spectrum::Modal<f32>>();
    logged::<spectrum::ModalDeviation<f32>>();
    logged::<spectrum::Roots<f32>>();
    #[cfg(feature = "monitor")]
    {
        logged::<monitor::Report<f32>>();
        logged::<monitor::MonitorError>();
        logged::<monitor::PairError>();
        logged::<decide::ChannelFault>();
        logged::<condition::Fault>();
        logged::<condition::HealthCounts>();
        logged::<advice::AdviceError>();
        logged::<act::ActError>();
    }
};
