//! The elastic linked system: receptances turned into any direction, and what they say
//! about the width of cut and the static stiffness there.
//!
//! Arithmetic only: receptances come from an exciter, a hammer or a model, and this
//! module does not ask which. Slow path, on the host or once per command; works on
//! borrowed slices, allocates nothing, refuses with a reason ([`ElsError`]).
//!
//! * [`Receptance`], the 2×2 tensor at one frequency, to any two directions;
//! * [`reciprocity`], how far the two cross receptances disagree;
//! * [`CutConfig`] and [`LimitSearch`], the limiting width of cut of one direction,
//!   [`polar_limits`] all round, [`extremes`] the best and the worst;
//! * [`static_stiffness`], the limit at zero frequency with its uncertainty;
//! * [`fit_modes`], natural frequencies and damping from a measured receptance, and
//!   [`agreed`], those on which fits of several orders agree.
//!
//! Words: *receptance*, displacement over force, m/N, for the time factor e^{+jωt};
//! *direct*, response and excitation in one direction; *cross*, in two; *oriented*,
//! between the direction of the cutting force and that of the chip thickness;
//! *overlap*, share of the wave of the pass before that is cut again.

mod complex;
mod consensus;
mod error;
mod limit;
mod modes;
mod polar;
mod rational;
mod receptance;
mod reciprocity;
mod stiffness;

pub use complex::Complex;
pub use consensus::{AgreedMode, Reading, agreed};
pub use error::ElsError;
pub use limit::{CutConfig, Limit, LimitSearch};
pub use modes::{FittedMode, ModesFit, fit_modes};
pub use polar::{Extremes, PolarPoint, extremes, polar_limits};
pub use receptance::Receptance;
pub use reciprocity::{Reciprocity, reciprocity};
pub use stiffness::{StaticStiffness, static_stiffness};
