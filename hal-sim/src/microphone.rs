//! A simulated microphone: hears a signal, a recording or a plant, and fails on
//! demand.

use firmware::{Block, BoardErrorKind};
use std::fmt;
use std::path::Path;

/// What can be made to go wrong, and when (s from the start).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MicrophoneFault {
    /// The converter delivers NaN for a while.
    NotFinite {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
    },
    /// The value stays where it is.
    Stuck {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
    },
    /// The gain is too high: everything beyond ±1 is cut.
    Overdriven {
        /// From, s.
        from_s: f64,
        /// To, s.
        to_s: f64,
        /// Gain.
        gain: f32,
    },
    /// Samples are lost once (an overrun); the source says so.
    Missing {
        /// At, s.
        at_s: f64,
        /// How many.
        samples: u32,
    },
    /// The source breaks off.
    Lost {
        /// At, s.
        at_s: f64,
    },
}

/// The microphone.
pub struct Microphone {
    signal: Box<dyn Iterator<Item = f32>>,
    fs_hz: f64,
    delivered: u64,
    faults: Vec<MicrophoneFault>,
    held: f32,
    missing: u32,
}

impl fmt::Debug for Microphone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Microphone")
            .field("fs_hz", &self.fs_hz)
            .field("delivered", &self.delivered)
            .field("faults", &self.faults)
            .finish_non_exhaustive()
    }
}

impl Microphone {
    /// Hears a signal of rate `fs_hz`, in fractions of full scale.
    pub fn hearing(signal: impl Iterator<Item = f32> + 'static, fs_hz: f64) -> Self {
        Self {
            signal: Box::new(signal),
            fs_hz,
            delivered: 0,
            faults: Vec::new(),
            held: 0.0,
            missing: 0,
        }
    }

    /// Hears the first channel of a WAV (16- to 32-bit PCM or 32-bit float).
    ///
    /// # Errors
    /// What the file's reader says.
    pub fn playing(path: &Path) -> Result<Self, hound::Error> {
        let mut reader = hound::WavReader::open(path)?;
        let spec = reader.spec();
        let step = usize::from(spec.channels);
        let samples: Result<Vec<f32>, _> = match spec.sample_format {
            hound::SampleFormat::Float => reader.samples::<f32>().step_by(step).collect(),
            hound::SampleFormat::Int => {
                let scale = 2f32.powi(1 - i32::from(spec.bits_per_sample));
                reader
                    .samples::<i32>()
                    .step_by(step)
                    .map(|x| x.map(|x| x as f32 * scale))
                    .collect()
            }
        };
        Ok(Self::hearing(
            samples?.into_iter(),
            f64::from(spec.sample_rate),
        ))
    }

    /// The same, with a fault to come.
    #[must_use]
    pub fn with_fault(mut self, fault: MicrophoneFault) -> Self {
        self.faults.push(fault);
        self
    }

    /// Sampling rate, Hz.
    pub fn fs_hz(&self) -> f64 {
        self.fs_hz
    }

    /// Samples of the simulated world that have gone by.
    pub(crate) fn delivered(&self) -> u64 {
        self.delivered
    }

    fn next(&mut self) -> Option<f32> {
        let x = self.signal.next()?;
        self.delivered += 1;
        Some(x)
    }

    /// The sample as the faults of this moment leave it; `Err` where the source
    /// has gone.
    fn spoil(&mut self, x: f32, t: f64) -> Result<f32, BoardErrorKind> {
        let mut y = x;
        for fault in &self.faults {
            match *fault {
                MicrophoneFault::NotFinite { from_s, to_s } if (from_s..to_s).contains(&t) => {
                    y = f32::NAN;
                }
                MicrophoneFault::Stuck { from_s, to_s } if (from_s..to_s).contains(&t) => {
                    return Ok(self.held);
                }
                MicrophoneFault::Overdriven { from_s, to_s, gain }
                    if (from_s..to_s).contains(&t) =>
                {
                    y = (y * gain).clamp(-1.0, 1.0);
                }
                MicrophoneFault::Lost { at_s } if t >= at_s => {
                    return Err(BoardErrorKind::SourceLost);
                }
                _ => {}
            }
        }
        self.held = y;
        Ok(y)
    }

    /// Loses the samples of an overrun that is due.
    fn lose(&mut self, t: f64) {
        let due = self
            .faults
            .iter()
            .position(|fault| matches!(fault, MicrophoneFault::Missing { at_s, .. } if t >= *at_s));
        if let Some(i) = due
            && let MicrophoneFault::Missing { samples, .. } = self.faults.remove(i)
        {
            for _ in 0..samples {
                if self.next().is_none() {
                    break;
                }
            }
            self.missing += samples;
        }
    }

    /// See [`Board::samples`](firmware::Board::samples).
    ///
    /// # Errors
    /// [`BoardErrorKind::SourceLost`]: it broke off.
    pub fn samples(&mut self, block: &mut [f32]) -> Result<Block, BoardErrorKind> {
        self.lose(self.delivered as f64 / self.fs_hz);
        let mut samples = 0;
        for place in block {
            let t = self.delivered as f64 / self.fs_hz;
            let Some(x) = self.next() else { break };
            *place = self.spoil(x, t)?;
            samples += 1;
        }
        Ok(Block {
            samples,
            missing: std::mem::take(&mut self.missing),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_come_when_they_are_due() {
        let mut m = Microphone::hearing((0..100).map(|n| n as f32), 100.0)
            .with_fault(MicrophoneFault::NotFinite {
                from_s: 0.02,
                to_s: 0.03,
            })
            .with_fault(MicrophoneFault::Stuck {
                from_s: 0.05,
                to_s: 0.07,
            })
            .with_fault(MicrophoneFault::Missing {
                at_s: 0.08,
                samples: 10,
            })
            .with_fault(MicrophoneFault::Lost { at_s: 0.5 });
        let mut block = [0.0; 8];
        assert_eq!(
            m.samples(&mut block).unwrap(),
            Block {
                samples: 8,
                missing: 0
            }
        );
        assert!(block[2].is_nan());
        assert_eq!(block[3..], [3.0, 4.0, 4.0, 4.0, 7.0]);
        assert_eq!(
            m.samples(&mut block).unwrap(),
            Block {
                samples: 8,
                missing: 10
            }
        );
        assert_eq!(block[0], 18.0);
        let mut reads = 0;
        while m.samples(&mut block).is_ok() {
            reads += 1;
        }
        assert_eq!(reads, 3);
    }
}
