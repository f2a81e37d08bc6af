//! Signals that excite: sample by sample, nothing allocated, known to the estimator.
//!
//! Every generator gives values of about unit rms or unit amplitude; the current they stand
//! for is the caller's factor, at most the bias (beyond it a coil reaches zero and the force
//! is rectified). Time: seconds from the first sample.
//!
//! | signal | crest factor | for |
//! |---|---|---|
//! | [`BandNoise`] | 3, clipped there | the thesis' choice; wants averages and a window |
//! | [`Prbs`] | 1 | most force for a limited current |
//! | [`multisine`], Schroeder | 1.7 | no leakage, lines of one's choice |
//! | the same after [`lower_crest`] | 1.5 | a table computed before |
//! | [`Sweep`] | 1.41 | one frequency at a time |

mod lines;
mod multisine;
mod noise;
mod prbs;
mod sweep;

pub use lines::{Dodge, LineSet, Lines, VoltageShape};
pub use multisine::{Phases, crest_factor, lower_crest, multisine};
pub use noise::{BandNoise, BandNoiseConfig};
pub use prbs::Prbs;
pub use sweep::{Course, Sweep};
