//! Time.

use embedded_hal::delay::DelayNs;
use firmware::Clock;
use std::cell::Cell;
use std::rc::Rc;

/// Time of a simulated board, ns; copies are the same clock. It goes on where somebody waits, and where a bus
/// carries bits.
#[derive(Debug, Clone, Default)]
pub struct SimTime(Rc<Cell<u64>>);

impl SimTime {
    /// Nanoseconds since the start.
    pub fn ns(&self) -> u64 {
        self.0.get()
    }

    /// Seconds since the start.
    pub fn seconds(&self) -> f64 {
        1e-9 * self.ns() as f64
    }

    /// So much of it goes by.
    pub fn pass_ns(&self, ns: u64) {
        self.0.set(self.0.get() + ns);
    }
}

impl Clock for SimTime {
    fn now_us(&mut self) -> u64 {
        self.ns() / 1000
    }
}

impl DelayNs for SimTime {
    fn delay_ns(&mut self, ns: u32) {
        self.pass_ns(u64::from(ns));
    }
}

/// A wait that takes no time, where a simulation lets none pass.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoTime;

impl DelayNs for NoTime {
    fn delay_ns(&mut self, _: u32) {}
}
