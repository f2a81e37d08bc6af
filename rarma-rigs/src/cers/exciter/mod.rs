//! The exciter at work: a job, the signal it asks for, and what a stepped sine finds out by
//! itself.
//!
//! ```text
//! ExcitationJob --check--> Source --a period--> change of the currents in x and y
//!                            ^                                 |
//!                            +-- force and motion measured <---+
//!                  Block (every half second or so) --> LineResponse
//! ```
//! The source runs in the current loop's interrupt, the rest on the main side.

mod check;
mod job;
mod response;
mod source;
mod steps;

pub use job::{Direction, ExcitationJob, JobField, OutOfReach, Reach, Signal};
pub use response::{LineCollector, LineResponse, SensorPath};
pub use source::Source;
pub use steps::{BLOCKS, Block, Seen};
