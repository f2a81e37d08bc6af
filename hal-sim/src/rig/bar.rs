//! The machine under the ball bar, for whoever stands at its panel.

use super::board::SimRig;
use rarma_plants::ldbb::{Bench, BenchConfig};

impl SimRig {
    /// Puts a machine under the bar. Its own air is not used: the rig's is.
    pub fn set_bar(&mut self, config: BenchConfig) {
        self.plant.bar = Some(Bench::new(config));
    }

    /// The machine, to start its programs.
    pub fn bar_mut(&mut self) -> Option<&mut Bench> {
        self.plant.bar.as_mut()
    }
}
