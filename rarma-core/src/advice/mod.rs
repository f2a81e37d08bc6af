//! Advice: which speed to turn instead, so that a cut that chatters becomes stable.
//!
//! Slow path, once an alarm. No allocation, bounded work (some 40 000 tests of a lobe with a
//! structure of eight modes; where frequencies of other cuts are known, 700 000 for each mode that
//! chattered, 0.06 s on a computer), single or double precision.
//!
//! Chatter feeds on the wave that the tooth before has left. Between two teeth it swings
//! w = f/(n·N) times; where w is a whole number the new wave lies on the old one and nothing
//! is fed. The plain rule turns at n = f/(k·N), k = 1, 2, …. It has two faults: f lies off the
//! structure's own frequency, so that its pockets lie beside the true ones, and it has a pocket
//! for every k, also where none is left. Both are mended here by the phase of the waves, see
//! [`Phase`] and [`Lobes`]; what is not known (damping, depth, the other modes) is a
//! belief: a set of cases, each with its lobes, and a speed is as good as the part of the
//! belief in which it is stable ([`advise`]). Other cuts with the same tool are evidence of it
//! ([`KnownCut`]): a stable one by its speed and depth, one that chattered by its frequency, too, which
//! tells mode and depth apart.
//!
//! Glossary: *waves*, f/(n·N); *pocket* k, the stable speeds between two lobes, where about k
//! waves fit between two teeth; *load*, half the cut's stiffness over the mode's, K·b/(2k_m):
//! the depth in the mode's own measure; *reach*, the speeds that may be turned.
//!
//! Sources: J. Tlusty, M. Polacek, and S. Tobias on regeneration (1950s); S. Smith, J. Tlusty,
//! "Stabilizing chatter by automatic spindle speed regulation", CIRP Annals 1992 (the plain
//! rule); the estimate of load and pocket from one heard frequency is worked out here.

mod belief;
mod config;
mod envelope;
mod evidence;
mod heard;
mod lobes;
mod mode;
mod phase;
mod propose;
mod swung;
#[cfg(test)]
mod tests;
mod vary;
#[cfg(test)]
mod vary_tests;

pub use config::{AdviceConfig, AdviceError, MOST_REACH};
pub use heard::{HeardChatter, KnownCut, MOST_KNOWN, Outcome};
pub use lobes::{Lobes, MOST_MARGIN, Side};
pub use phase::Phase;
pub use propose::{Advice, Help, Proposal, advise, advise_by};
pub use vary::{Variation, VariationConfig, vary};
