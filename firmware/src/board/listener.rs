//! A board that only listens: samples, link, settings and watchdog. [`ListeningBox`](crate::ListeningBox)
//! makes the whole box's board of it.

use super::{Board, Lights, ResetCause};
use core::ops::Range;
use rarma_box::guard::KEPT_BYTES;

/// The verbs of a board that listens, beside a [`Board`]'s. Each has the contract of [`BoxBoard`](super::BoxBoard)'s verb of its name.
pub trait Listener: Board {
    /// Flash that holds the settings and nothing else.
    type Flash: embedded_storage::nor_flash::NorFlash;

    /// Name of the board, for the host.
    const NAME: &'static str;
    /// Rate of the microphone's samples, Hz.
    const SAMPLE_RATE_HZ: f64;

    /// See [`BoxBoard::wait`](super::BoxBoard::wait).
    fn wait(&mut self);

    /// See [`BoxBoard::receive`](super::BoxBoard::receive).
    ///
    /// # Errors
    /// As there.
    fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error>;

    /// See [`BoxBoard::flash`](super::BoxBoard::flash).
    fn flash(&mut self) -> (&mut Self::Flash, Range<u32>);

    /// See [`BoxBoard::entropy`](super::BoxBoard::entropy).
    fn entropy(&mut self) -> u32;

    /// See [`Emergency::keep`](super::Emergency::keep).
    fn keep(&mut self, bytes: &[u8; KEPT_BYTES]);

    /// See [`BoxBoard::kept`](super::BoxBoard::kept).
    fn kept(&mut self) -> [u8; KEPT_BYTES];

    /// See [`BoxBoard::reset_cause`](super::BoxBoard::reset_cause).
    fn reset_cause(&mut self) -> ResetCause;

    /// See [`BoxBoard::feed_watchdog`](super::BoxBoard::feed_watchdog).
    fn feed_watchdog(&mut self);

    /// See [`BoxBoard::lights`](super::BoxBoard::lights); a board may have none.
    fn lights(&mut self, lights: Lights) {
        let _ = lights;
    }
}
