//! No controller: nothing is ordered, and what would be is said.

use super::Controller;
use crate::failure::Failure;
use rarma_core::act::{ActOrder, Overrides, Reading};

/// Takes the speed that is believed for the programmed one, and every order for done.
#[derive(Debug, Default)]
pub struct Dry {
    spindle_hz: Option<f64>,
}

impl Controller for Dry {
    fn range(&self) -> Option<(f64, f64)> {
        Some((0.1, 2.0))
    }

    fn read(&mut self) -> Result<Option<Reading>, Failure> {
        let overrides = Overrides {
            spindle: 1.0,
            feed: 1.0,
        };
        Ok(self.spindle_hz.map(|program_hz| Reading {
            program_hz,
            actual_hz: None,
            overrides,
            operator: None,
            running: true,
            stopped: false,
        }))
    }

    fn propose(&mut self, _: &[f64]) -> Result<(), Failure> {
        Ok(())
    }

    fn order(&mut self, _: ActOrder) -> Result<(), Failure> {
        Ok(())
    }

    fn believe(&mut self, spindle_hz: f64) {
        self.spindle_hz = Some(spindle_hz);
    }
}
