//! The link over any port of embedded-io.

use super::PartFailed;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use heapless::Deque;

/// A port with `N` bytes before it, so that a frame is taken whole or not at all and nothing waits.
#[derive(Debug)]
pub struct PortLink<L, const N: usize> {
    pub(super) port: L,
    waiting: Deque<u8, N>,
}

impl<L: Read + ReadReady + Write + WriteReady, const N: usize> PortLink<L, N> {
    /// On this port.
    pub fn new(port: L) -> Self {
        Self {
            port,
            waiting: Deque::new(),
        }
    }

    /// See [`BoxBoard::receive`](crate::BoxBoard::receive).
    ///
    /// # Errors
    /// [`PartFailed::Link`]: the port is down.
    pub fn receive(&mut self, bytes: &mut [u8]) -> Result<usize, PartFailed> {
        match self.port.read_ready() {
            Ok(true) => self.port.read(bytes).map_err(|_| PartFailed::Link),
            Ok(false) => Ok(0),
            Err(_) => Err(PartFailed::Link),
        }
    }

    /// See [`Board::send`](crate::Board::send).
    ///
    /// # Errors
    /// Nothing has been taken: there is no room ([`PartFailed::Busy`]), and the port is down
    /// ([`PartFailed::Link`]).
    pub fn send(&mut self, frame: &[u8]) -> Result<(), PartFailed> {
        if N - self.waiting.len() < frame.len() {
            self.pump()?;
        }
        if N - self.waiting.len() < frame.len() {
            return Err(PartFailed::Busy);
        }
        for &byte in frame {
            let _ = self.waiting.push_back(byte);
        }
        // What fails here fails again at the next call; the frame is taken.
        let _ = self.pump();
        Ok(())
    }

    /// Hands the port what it takes without waiting; to be called in every pass
    /// ([`BoxBoard::wait`](crate::BoxBoard::wait)).
    ///
    /// # Errors
    /// [`PartFailed::Link`]: the port is down.
    pub fn pump(&mut self) -> Result<(), PartFailed> {
        while !self.waiting.is_empty() && self.port.write_ready().map_err(|_| PartFailed::Link)? {
            let (front, _) = self.waiting.as_slices();
            let taken = self.port.write(front).map_err(|_| PartFailed::Link)?;
            if taken == 0 {
                return Err(PartFailed::Link);
            }
            for _ in 0..taken {
                self.waiting.pop_front();
            }
        }
        Ok(())
    }
}
