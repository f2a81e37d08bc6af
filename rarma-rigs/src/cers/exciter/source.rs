//! The signal, one period of the current loop at a time.

use super::job::{Direction, ExcitationJob, Signal};
use super::steps::{Block, Seen, Steps};
use crate::cers::error::{CersError, within};
use crate::cers::excitation::{BandNoise, BandNoiseConfig, Course, Prbs, Sweep};

/// Time to full amplitude and back, s.
const FADE_S: f32 = 0.01;
/// Bits of the binary sequence: 8191 states.
const PRBS_BITS: u32 = 13;
/// Its spectrum is 3 dB down at this part of its clock.
const PRBS_PART: f32 = 0.443;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Noise([BandNoise<f32>; 2]),
    Prbs([Prbs; 2]),
    Sweep(Sweep<f32>),
    Steps(Steps),
}

/// A running signal. The same job gives the same numbers.
///
/// Rate: once a period of the current loop. Fast path: no allocation, no panic, no f64.
#[derive(Debug, Clone, Copy)]
pub struct Source {
    kind: Kind,
    direction: Direction,
    /// Amplitude of a unit of the signal, A.
    scale_a: f32,
    left: u32,
    fading: f32,
    per_period: f32,
    /// Periods of a fade.
    fade: u32,
    ended: bool,
}

impl Source {
    /// The signal of a job at the rate of the current loop, Hz; `spindle_hz` as in
    /// [`Reach`](super::Reach::spindle_hz).
    ///
    /// # Errors
    /// `OutOfRange` with the first field.
    pub fn new(job: &ExcitationJob, rate_hz: f32, spindle_hz: f32) -> Result<Self, CersError> {
        within(rate_hz, 1e3, 2e5, "rate_hz")?;
        within(job.high_hz, 10.0, 0.45 * rate_hz, "high_hz")?;
        let least = if job.signal == Signal::Noise {
            0.0
        } else {
            1.0
        };
        within(job.low_hz, least, 0.8 * job.high_hz, "low_hz")?;
        let kind = match job.signal {
            Signal::Noise => {
                let noise = BandNoise::new(&BandNoiseConfig {
                    rate_hz,
                    low_hz: job.low_hz,
                    high_hz: job.high_hz,
                    seed: 1,
                })?;
                Kind::Noise([noise, noise.with_seed(2)])
            }
            Signal::Prbs => {
                let hold = (rate_hz * PRBS_PART / job.high_hz) as u32;
                let sequence = Prbs::new(PRBS_BITS, hold.clamp(1, 1000))?;
                // Half a period later: orthogonal to responses that are over by then.
                Kind::Prbs([sequence, sequence.advanced(1 << (PRBS_BITS - 1))])
            }
            Signal::Sweep => Kind::Sweep(Sweep::new(
                rate_hz,
                (job.low_hz, job.high_hz),
                job.seconds,
                Course::Logarithmic,
            )?),
            Signal::Steps => Kind::Steps(Steps::new(job, rate_hz, spindle_hz)?),
        };
        // Steps end themselves; twice their time is a limit that they do not reach.
        let limit = if job.signal == Signal::Steps {
            2.0
        } else {
            1.0
        };
        let left = (job.seconds * rate_hz * limit) as u32;
        let sine = matches!(job.signal, Signal::Sweep | Signal::Steps);
        Ok(Self {
            kind,
            direction: job.direction,
            scale_a: job.rms_a * if sine { core::f32::consts::SQRT_2 } else { 1.0 },
            left,
            fading: 0.0,
            per_period: 1.0 / (FADE_S * rate_hz),
            fade: libm::ceilf(FADE_S * rate_hz) as u32,
            ended: false,
        })
    }

    /// Changes of the current in x and y for the next period, A; none once it is over.
    #[inline]
    pub fn next_period(&mut self) -> Option<[f32; 2]> {
        self.left = self.left.checked_sub(1)?;
        if self.fading < 1.0 || self.left <= self.fade {
            let end = self.left as f32 * self.per_period;
            self.fading = (self.fading + self.per_period).min(1.0).min(end);
        }
        let scale = self.scale_a * self.fading;
        let unit = match &mut self.kind {
            Kind::Noise(noise) => each(noise, self.direction, BandNoise::next_sample),
            Kind::Prbs(sequence) => each(sequence, self.direction, Prbs::next_sample),
            Kind::Sweep(sweep) => {
                let x = sweep.next_sample();
                match self.direction {
                    Direction::X => [x, 0.0],
                    Direction::Y => [0.0, x],
                    // One after the other would be two jobs: together they push at 45°.
                    Direction::Both => [core::f32::consts::FRAC_1_SQRT_2 * x; 2],
                }
            }
            Kind::Steps(steps) => steps.next_period(),
        };
        Some(unit.map(|x| x * scale))
    }

    /// Ends early: fades from now on.
    #[inline]
    pub fn end(&mut self) {
        if self.ended {
            return;
        }
        self.ended = true;
        let fade = (self.fading / self.per_period) as u32;
        self.left = self.left.min(fade);
    }

    /// The axis whose force it wants to see, and with it the motion; none if it measures
    /// nothing.
    #[inline]
    pub fn measures(&self) -> Option<u8> {
        match &self.kind {
            Kind::Steps(steps) => Some(steps.axis()),
            _ => None,
        }
    }

    /// What was measured in the period of the last [`Self::next_period`]. A block of a line
    /// that is complete.
    #[inline]
    pub fn see(&mut self, seen: &Seen) -> Option<Block> {
        let Kind::Steps(steps) = &mut self.kind else {
            return None;
        };
        // A fade is no measurement.
        let block = steps.see(seen).filter(|_| !self.ended);
        if steps.is_over() {
            self.end();
        }
        block
    }
}

#[inline(always)]
fn each<S>(pair: &mut [S; 2], direction: Direction, next: impl Fn(&mut S) -> f32) -> [f32; 2] {
    let [x, y] = pair;
    [
        if direction.drives(0) { next(x) } else { 0.0 },
        if direction.drives(1) { next(y) } else { 0.0 },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const JOB: ExcitationJob = ExcitationJob {
        signal: Signal::Noise,
        direction: Direction::Both,
        rms_a: 0.1,
        low_hz: 150.0,
        high_hz: 5e3,
        seconds: 2.0,
        lines: 4,
    };

    fn run(job: &ExcitationJob) -> Vec<[f32; 2]> {
        let mut source = Source::new(job, 40e3, 0.0).unwrap();
        core::iter::from_fn(|| {
            let x = source.next_period();
            source.see(&Seen::default());
            x
        })
        .collect()
    }

    #[test]
    fn every_signal_has_its_time_its_level_and_a_soft_beginning_and_end() {
        for signal in Signal::ALL {
            for direction in Direction::ALL {
                let job = ExcitationJob {
                    signal,
                    direction,
                    ..JOB
                };
                let x = run(&job);
                let length = x.len() as f32 / 40e3;
                assert!((1.9..=2.011).contains(&length), "{signal:?}: {length} s");
                let rms = |axis: usize| {
                    let sum: f32 = x[400..x.len() - 400].iter().map(|x| x[axis].powi(2)).sum();
                    (sum / (x.len() - 800) as f32).sqrt()
                };
                for axis in 0..2 {
                    let most = x.iter().map(|x| x[axis].abs()).fold(0.0, f32::max);
                    assert!(most <= 1.0001 * job.peak_a(), "{signal:?}: {most}");
                    let wanted = match (direction.drives(axis), signal, direction) {
                        (false, ..) => 0.0,
                        // Steps: half of the time each; sweeps: at 45°.
                        (true, Signal::Steps | Signal::Sweep, Direction::Both) => 0.0707,
                        (true, ..) => 0.1,
                    };
                    assert!(
                        (rms(axis) - wanted).abs() < 0.004,
                        "{signal:?} {direction:?} {axis}: {}",
                        rms(axis)
                    );
                }
                for near in [&x[..40], &x[x.len() - 40..]] {
                    assert!(near.iter().flatten().all(|x| x.abs() < 0.11 * job.peak_a()));
                }
            }
        }
    }

    #[test]
    fn two_directions_have_nothing_in_common() {
        for signal in [Signal::Noise, Signal::Prbs] {
            let x = run(&ExcitationJob {
                signal,
                seconds: 20.0,
                ..JOB
            });
            let dot: f64 = x.iter().map(|x| f64::from(x[0] * x[1])).sum();
            let part = dot / (0.01 * x.len() as f64);
            // Noise of 5 kHz for 20 s: 1/√(2·5000·20) = 0.0022.
            assert!(part.abs() < 0.009, "{signal:?}: {part}");
        }
    }

    #[test]
    fn an_early_end_fades_too() {
        let mut source = Source::new(&JOB, 40e3, 0.0).unwrap();
        for _ in 0..10_000 {
            source.next_period().unwrap();
        }
        source.end();
        let rest: Vec<_> = core::iter::from_fn(|| source.next_period()).collect();
        assert!((399..=401).contains(&rest.len()), "{}", rest.len());
        assert!(rest[395..].iter().flatten().all(|x| x.abs() < 0.01));
        // Ended at once, it is over at once.
        let mut source = Source::new(&JOB, 40e3, 0.0).unwrap();
        source.end();
        assert_eq!(source.next_period(), None);
    }
}
