//! What is to be excited, and whether that is within reach.

use crate::cers::error::CersError;
use serde::{Deserialize, Serialize};

/// Kind of signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Signal {
    /// Band-limited Gaussian noise, clipped at three standard deviations.
    Noise,
    /// Pseudo-random binary sequence of 13 bits: flat to 0.443 of its clock (−3 dB), which
    /// is the first whole part of the rate that reaches the upper edge there.
    Prbs,
    /// One sine, swept logarithmically.
    Sweep,
    /// One sine after the other, each held; the response is read off by the exciter itself.
    Steps,
}

impl Signal {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Noise, Self::Prbs, Self::Sweep, Self::Steps];

    /// As it is typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Noise => "noise",
            Self::Prbs => "prbs",
            Self::Sweep => "sweep",
            Self::Steps => "steps",
        }
    }

    /// Largest value over the root mean square.
    pub const fn crest(self) -> f32 {
        match self {
            Self::Noise => 3.0,
            Self::Prbs => 1.0,
            Self::Sweep | Self::Steps => core::f32::consts::SQRT_2,
        }
    }
}

/// Where it pulls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Direction {
    /// X alone.
    X,
    /// Y alone.
    Y,
    /// Both at once by signals that have nothing in common; steps: X, then Y.
    Both,
}

impl Direction {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Both];

    /// As it is typed.
    pub const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Both => "both",
        }
    }

    /// Whether an axis (0 is x) is driven.
    pub const fn drives(self, axis: usize) -> bool {
        match self {
            Self::X => axis == 0,
            Self::Y => axis == 1,
            Self::Both => axis < 2,
        }
    }
}

/// A change of the currents about the bias: i₀ + i_c in the + coil, i₀ − i_c in the − coil.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ExcitationJob {
    /// Kind.
    pub signal: Signal,
    /// Direction.
    pub direction: Direction,
    /// Root mean square of the change i_c, A.
    pub rms_a: f32,
    /// Band, Hz. Noise may start at 0.
    pub low_hz: f32,
    /// See [`Self::low_hz`].
    pub high_hz: f32,
    /// For so long, s: 0.1 to 3600. Steps: both directions together.
    pub seconds: f32,
    /// Steps in a direction, 2 to 2000; otherwise without meaning.
    pub lines: u16,
}

/// Slope of noise from a filter of fourth order over that from a band with sharp edges.
const SKIRTS: f32 = 1.06;

/// What the coils and their supply can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reach {
    /// Rate of the current loop, Hz.
    pub rate_hz: f32,
    /// Bias, A.
    pub bias_a: f32,
    /// No current of a coil goes beyond this, A.
    pub most_a: f32,
    /// Voltage that the bridges can give: supply times the largest duty, V.
    pub volts: f32,
    /// Inductance of a coil, H.
    pub inductance_h: f32,
    /// Resistance of a coil, Ω.
    pub resistance_ohm: f32,
    /// Proportional gain of the regulators, V/A.
    pub proportional: f32,
    /// Every magnet is calibrated.
    pub calibrated: bool,
    /// Speed of the spindle, revolutions/s: steps keep away from its first four multiples.
    /// 0: at rest, or not known.
    pub spindle_hz: f32,
}

/// A field of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum JobField {
    /// `rms_a`.
    Rms,
    /// `low_hz`.
    Low,
    /// `high_hz`.
    High,
    /// `seconds`; with steps: too short for the lines.
    Seconds,
    /// `lines`.
    Lines,
}

/// Why a job does not go. Each figure in V or A.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum OutOfReach {
    /// A field is out of its range.
    Field(JobField),
    /// The force of the magnets is not known: they are not calibrated.
    Uncalibrated,
    /// The bias alone takes more voltage than the supply gives.
    Bias {
        /// V.
        needed: f32,
        /// V.
        there: f32,
    },
    /// Peaks beyond the bias, where a coil is without current and the force is rectified, or
    /// beyond the greatest current.
    Current {
        /// A.
        peak: f32,
        /// A.
        allowed: f32,
    },
    /// The supply cannot drive the current through the inductance that fast.
    Voltage {
        /// V.
        needed: f32,
        /// V.
        there: f32,
    },
}

impl From<CersError> for OutOfReach {
    fn from(error: CersError) -> Self {
        let CersError::OutOfRange { name } = error else {
            return Self::Field(JobField::High);
        };
        Self::Field(match name {
            "low_hz" | "from_hz" => JobField::Low,
            "seconds" => JobField::Seconds,
            "lines" => JobField::Lines,
            _ => JobField::High,
        })
    }
}

impl Reach {
    /// Whether the bias leaves the supply anything.
    ///
    /// # Errors
    /// [`OutOfReach::Bias`].
    pub fn bias(&self) -> Result<(), OutOfReach> {
        let needed = self.resistance_ohm * self.bias_a;
        if needed < self.volts {
            Ok(())
        } else {
            Err(OutOfReach::Bias {
                needed,
                there: self.volts,
            })
        }
    }
}

impl ExcitationJob {
    /// Largest change of a current, A.
    pub fn peak_a(&self) -> f32 {
        self.signal.crest() * self.rms_a
    }

    /// Voltage that the change takes beyond R·i, V.
    ///
    /// A sine of amplitude a needs 2πf·L·a at the upper edge; noise three deviations of its
    /// slope, 2πL·√((f_h³ − f_l³)/(3(f_h − f_l))) a unit and 6 % for the skirts of the band,
    /// which leaves some periods in a thousand at the limit; a step of a binary sequence the
    /// proportional gain times its height.
    pub fn volts(&self, reach: &Reach) -> f32 {
        let per_hz = core::f32::consts::TAU * reach.inductance_h;
        match self.signal {
            Signal::Sweep | Signal::Steps => per_hz * self.high_hz * self.peak_a(),
            Signal::Noise => {
                let (l, h) = (self.low_hz, self.high_hz);
                // (h³ − l³)/(h − l) = h² + hl + l².
                let square = (h * h + h * l + l * l) / 3.0;
                SKIRTS * per_hz * libm::sqrtf(square) * self.peak_a()
            }
            Signal::Prbs => 2.0 * reach.proportional * self.rms_a,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REACH: Reach = Reach {
        rate_hz: 40e3,
        bias_a: 0.8,
        most_a: 2.5,
        volts: 0.95 * 48.0,
        inductance_h: 4.19e-3,
        resistance_ohm: 4.0,
        proportional: 58.0,
        calibrated: true,
        spindle_hz: 0.0,
    };
    const JOB: ExcitationJob = ExcitationJob {
        signal: Signal::Noise,
        direction: Direction::Both,
        rms_a: 0.15,
        low_hz: 150.0,
        high_hz: 5e3,
        seconds: 10.0,
        lines: 0,
    };

    fn refused(job: ExcitationJob, reach: Reach) -> OutOfReach {
        job.check(&reach).map(|_| ()).unwrap_err()
    }

    #[test]
    fn what_goes_goes() {
        for signal in Signal::ALL {
            let job = ExcitationJob {
                signal,
                lines: 10,
                ..JOB
            };
            assert!(job.check(&REACH).is_ok(), "{signal:?}");
        }
    }

    #[test]
    fn each_reason_is_told_with_its_figures() {
        let off = Reach {
            calibrated: false,
            ..REACH
        };
        assert_eq!(refused(JOB, off), OutOfReach::Uncalibrated);
        let bias = Reach {
            bias_a: 12.0,
            most_a: 30.0,
            ..REACH
        };
        assert!(matches!(refused(JOB, bias), OutOfReach::Bias { needed, .. } if needed == 48.0));
        let loud = ExcitationJob { rms_a: 0.3, ..JOB };
        assert!(
            matches!(refused(loud, REACH), OutOfReach::Current { allowed, .. } if allowed == 0.8)
        );
        let high = Reach {
            most_a: 1.0,
            ..REACH
        };
        assert!(matches!(refused(JOB, high), OutOfReach::Current { .. }));
        // A sine of 0.4 A at 5 kHz takes 53 V of 42.
        let sine = ExcitationJob {
            signal: Signal::Sweep,
            rms_a: 0.4 / core::f32::consts::SQRT_2,
            ..JOB
        };
        let OutOfReach::Voltage { needed, there } = refused(sine, REACH) else {
            panic!("not for its voltage");
        };
        assert!(
            (needed - 52.65).abs() < 0.1 && (there - 40.8).abs() < 0.01,
            "{needed} {there}"
        );
        for bad in [
            ExcitationJob {
                rms_a: f32::NAN,
                ..JOB
            },
            ExcitationJob { rms_a: 0.0, ..JOB },
            ExcitationJob {
                seconds: 0.0,
                ..JOB
            },
            ExcitationJob {
                high_hz: 30e3,
                ..JOB
            },
            ExcitationJob {
                low_hz: -1.0,
                ..JOB
            },
            ExcitationJob { low_hz: 5e3, ..JOB },
            ExcitationJob {
                signal: Signal::Steps,
                lines: 1,
                ..JOB
            },
            ExcitationJob {
                signal: Signal::Steps,
                lines: 2000,
                seconds: 1.0,
                ..JOB
            },
        ] {
            assert!(
                matches!(refused(bad, REACH), OutOfReach::Field(_)),
                "{bad:?}"
            );
        }
    }

    #[test]
    fn noise_needs_the_voltage_its_slope_has() {
        // The largest slope of a long stretch of it, against what is reckoned with.
        let mut source = JOB.check(&REACH).unwrap();
        let (mut last, mut steepest, mut square) = (0.0f32, 0.0f32, 0.0f64);
        for n in 0..300_000 {
            let x = source.next_period().unwrap()[0];
            if n > 1000 {
                let slope = (x - last) * 40e3;
                steepest = steepest.max(slope.abs());
                square += f64::from(slope * slope);
            }
            last = x;
        }
        let volts = REACH.inductance_h * (square / 3e5).sqrt() as f32;
        println!(
            "rms {volts:.1} V, peak {:.1} V, reckoned {:.1} V",
            REACH.inductance_h * steepest,
            JOB.volts(&REACH)
        );
        let part = 3.0 * volts / JOB.volts(&REACH);
        assert!((0.97..1.03).contains(&part), "{part}");
    }
}
