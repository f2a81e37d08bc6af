//! The signal path: models, roots, the whole chain, the spindle's lines.

use super::Kernel;
use rarma_core::Order;
use rarma_core::condition::{
    Band, SpeedFinder, SpeedFinderConfig, SpindleLines, SpindleLinesConfig,
};
use rarma_core::estimate::{RarmaConfig, RecursiveArma};
use rarma_core::monitor::{Monitor, MonitorConfig};
use rarma_core::spectrum::{FactorTracker, modal};
use rarma_core::verdict::{Listening, Verdict, VerdictConfig};

macro_rules! order_kernels {
    ($($update:ident, $roots:ident, $chain:ident, $p:literal, $q:literal, $n:literal;)*) => {
        $(
            /// Parameters, covariance and gradient of one model.
            pub struct $update(RecursiveArma<f32, $p, $q, $n>);

            impl Kernel for $update {
                const NAME: &'static str =
                    concat!("update (", $p, ",", $q, ")");
                fn new() -> Self {
                    Self(RecursiveArma::new(forgetting()))
                }
                fn step(&mut self, y: f32) -> f32 {
                    self.0.update(y).innovation
                }
            }

            /// The same, and the roots of A, and frequency and damping of each mode.
            pub struct $roots {
                model: RecursiveArma<f32, $p, $q, $n>,
                roots: FactorTracker<f32, $p>,
            }

            impl Kernel for $roots {
                const NAME: &'static str =
                    concat!("update, roots, damping (", $p, ",", $q, ")");
                fn new() -> Self {
                    Self {
                        model: RecursiveArma::new(forgetting()),
                        roots: FactorTracker::new(),
                    }
                }
                fn step(&mut self, y: f32) -> f32 {
                    self.model.update(y);
                    self.roots.track(self.model.a());
                    let mut sum = 0.0;
                    for factor in self.roots.factors($p) {
                        if let Some(mode) = modal(factor, 6000.0) {
                            sum += mode.damping;
                        }
                    }
                    sum
                }
            }

            /// The whole chain from a 48 kHz sample to the verdict, per input sample.
            pub struct $chain(Monitor<f32>);

            impl Kernel for $chain {
                const NAME: &'static str =
                    concat!("whole chain per 48 kHz sample (", $p, ",", $q, ")");
                fn new() -> Self {
                    let Some(order) = Order::new($p, $q) else {
                        panic!("the box has the order");
                    };
                    match Monitor::new(&MonitorConfig {
                        order,
                        ..MonitorConfig::new(48_000.0)
                    }) {
                        Ok(monitor) => Self(monitor),
                        Err(_) => panic!("the default settings are in range"),
                    }
                }
                fn step(&mut self, y: f32) -> f32 {
                    self.0.push(y).map_or(0.0, |report| report.level)
                }
            }
        )*
    };
}

order_kernels! {
    Update21, Roots21, Chain21, 2, 1, 3;
    Update22, Roots22, Chain22, 2, 2, 4;
    Update43, Roots43, Chain43, 4, 3, 7;
    Update44, Roots44, Chain44, 4, 4, 8;
    Update65, Roots65, Chain65, 6, 5, 11;
    Update66, Roots66, Chain66, 6, 6, 12;
    Update87, Roots87, Chain87, 8, 7, 15;
    Update88, Roots88, Chain88, 8, 8, 16;
}

/// The signal with lines of a five-tooth cutter at 76.4 Hz in it, made as it runs.
struct Cut(u32);

impl Cut {
    fn next(&mut self, y: f32) -> f32 {
        // 26 turns in 2042 samples of 6 kHz: teeth in 15.7 samples.
        self.0 = (self.0 + 130) % 2042;
        y + if self.0 < 130 { 60.0 } else { -4.0 }
    }
}

/// Removal of all lines of one spindle in the band, per decimated sample.
pub struct Lines(SpindleLines<f32, 32>, Cut);

impl Kernel for Lines {
    const NAME: &'static str = "spindle lines (32)";
    fn new() -> Self {
        let band = Band::usual(6000.0);
        match SpindleLines::new(&SpindleLinesConfig::new(6000.0, band)) {
            Ok(mut lines) => {
                lines.start(76.4, 0.05);
                Self(lines, Cut(0))
            }
            Err(_) => panic!("the settings are in range"),
        }
    }
    fn step(&mut self, y: f32) -> f32 {
        let y = self.1.next(y);
        self.0.process(y)
    }
}

/// Search for the speed in the sound, per decimated sample.
pub struct Finder(SpeedFinder<f32>, Cut);

impl Kernel for Finder {
    const NAME: &'static str = "speed from the sound";
    fn new() -> Self {
        match SpeedFinder::new(&SpeedFinderConfig {
            fs_hz: 6000.0,
            band: Band::usual(6000.0),
            told_hz: None,
            teeth: None,
        }) {
            Ok(finder) => Self(finder, Cut(0)),
            Err(_) => panic!("the settings are in range"),
        }
    }
    fn step(&mut self, y: f32) -> f32 {
        let y = self.1.next(y);
        f32::from(u8::from(self.0.push(y).is_some()))
    }
}

/// The verdict by lines with a told speed, per decimated sample.
pub struct ByLines(Verdict<f32>, Cut);

impl Kernel for ByLines {
    const NAME: &'static str = "verdict by lines, speed told";
    fn new() -> Self {
        let listening = Listening {
            fs_hz: 6000.0,
            spindle_hz: Some(76.4),
            teeth: Some(5),
            folding_hz: None,
        };
        match Verdict::new(&VerdictConfig::default(), &listening) {
            Ok(verdict) => Self(verdict, Cut(0)),
            Err(_) => panic!("the default settings are in range"),
        }
    }
    fn step(&mut self, y: f32) -> f32 {
        let y = self.1.next(y);
        self.0
            .process(y)
            .map_or(0.0, |judgement| judgement.evidence)
    }
}

fn forgetting() -> RarmaConfig<f32> {
    RarmaConfig {
        forgetting: 0.998,
        variance_gain: 0.002,
        ..RarmaConfig::default()
    }
}
