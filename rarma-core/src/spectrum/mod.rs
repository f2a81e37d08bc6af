//! From a model to what vibrates: roots, poles, modes.
//!
//! Words: *factor*, a real quadratic z² − u·z + v of A; *pole pair*, its two
//! complex roots; *mode*, a pole pair with its place in time kept.

mod aberth;
mod envelope;
mod factors;
mod isolate;
mod lockin;
mod poles;
mod quadratic;

pub use envelope::{
    ENVELOPE_FLOOR_HZ, ENVELOPE_WIDTHS, Envelope, envelope_corner, envelope_half_width,
};
pub use factors::{FactorTracker, Tracking};
pub use isolate::isolate;
pub use lockin::{LOCKIN_TAU_S, LockIn};
pub use poles::{Modal, ModalDeviation, deviation, modal};
pub use quadratic::{Quadratic, Roots};
