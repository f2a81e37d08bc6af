//! Controllers of machine tools that an override can be ordered of.
//!
//! Each port is thin: it reads, it sends, and it decides nothing; what is ordered, and when,
//! is [`rarma_core::act`]'s. [`Actor`] puts policy, advice, port and log together.

mod actor;
mod charts;
mod dry;
pub mod grbl;
pub mod linuxcnc;
mod log;

pub use actor::{Actor, Chatter};
pub use charts::Charts;
pub use dry::Dry;
pub use grbl::Grbl;
pub use linuxcnc::LinuxCnc;
pub use log::{ActLog, ActRecord, What, words};

use crate::failure::Failure;
use rarma_core::act::{ActOrder, Reading};

/// A machine's controller. Every call returns at once.
pub trait Controller: Send {
    /// The smallest and the largest override of the speed that it takes, 1 = 100 %; none
    /// until it is known.
    fn range(&self) -> Option<(f64, f64)>;

    /// How fast its override can be changed, 1 = 100 % a second; none: as fast as is wanted.
    fn fastest_per_s(&self) -> Option<f64> {
        None
    }

    /// What it has reported since the last call, if anything.
    ///
    /// # Errors
    /// It is gone; in one line.
    fn read(&mut self) -> Result<Option<Reading>, Failure>;

    /// Shows overrides that are proposed, the best first, where it has a place for them.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn propose(&mut self, overrides: &[f64]) -> Result<(), Failure>;

    /// Does as ordered. An order that stands is said again some fifty times a second: where
    /// that stays away for half a second, and the controller can tell, it gives back by itself.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    fn order(&mut self, order: ActOrder) -> Result<(), Failure>;

    /// The speed that the listening believes in, turns a second: for those who know no other.
    fn believe(&mut self, spindle_hz: f64);
}
