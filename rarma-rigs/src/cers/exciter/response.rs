//! From the blocks of a line to its response, corrected for what stands in between.
//!
//! Rate: once a line. Main side.

use super::steps::{BLOCKS, Block};
use crate::cers::eddy::Eddy;
use crate::cers::frf::Path;
use crate::els::Complex;

/// What stands between the structure and the numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPath {
    /// Corner of the displacement sensors (second order, Butterworth), Hz; 0: none.
    pub corner_hz: f32,
    /// Lag of the flux; none: not corrected.
    pub eddy: Option<Eddy<f32>>,
    /// ∂F/∂x of x and y at the bias
    /// ([`AxisForce::derivatives`](crate::cers::AxisForce::derivatives)), N/m.
    ///
    /// The force is rebuilt with the gap as its sensor follows it. kₓ·(x − x_seen) is what
    /// that leaves out: 2 % of the force where 0.3 µm/N are seen 16° late.
    pub pull_n_per_m: [f32; 2],
}

impl SensorPath {
    fn path(&self, f_hz: f32) -> Path<f32> {
        let one = Complex::new(1.0, 0.0);
        let motion_sensor = if self.corner_hz > 0.0 {
            // 1/(1 + √2·p + p²), p = jf/f_c.
            let p = f_hz / self.corner_hz;
            Complex::new(1.0 - p * p, core::f32::consts::SQRT_2 * p).inverse()
        } else {
            one
        };
        Path {
            motion_sensor,
            force_lag: self.eddy.map_or(one, |e| e.flux(f_hz)),
            ..Path::none()
        }
    }
}

/// Response of the structure to the force of one axis at one frequency.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LineResponse {
    /// Driven axis, 0 is x.
    pub axis: u8,
    /// Line, from 0.
    pub line: u16,
    /// Frequency, Hz.
    pub f_hz: f32,
    /// Amplitude of the force, N.
    pub force_n: f32,
    /// Receptance of x and y, m/N, e^{+jωt}.
    pub receptance: [Complex<f32>; 2],
    /// Standard deviation of the real and of the imaginary part of each, m/N, from the
    /// scatter of the blocks.
    pub sd: [f32; 2],
    /// Every force could be relied upon.
    pub trusted: bool,
}

/// Collects the blocks of a line.
#[derive(Debug, Clone, Copy, Default)]
pub struct LineCollector {
    blocks: [Block; BLOCKS as usize],
}

impl LineCollector {
    /// A block; the response with the last one of a line, none if one was lost on the way or
    /// there was no force.
    pub fn add(&mut self, block: &Block, path: &SensorPath) -> Option<LineResponse> {
        let place = self.blocks.get_mut(usize::from(block.block))?;
        *place = *block;
        if u32::from(block.block) + 1 < BLOCKS {
            return None;
        }
        let of_line = |b: &&Block| (b.axis, b.line) == (block.axis, block.line);
        if self.blocks.iter().filter(of_line).count() < BLOCKS as usize {
            return None;
        }
        let pull = path.pull_n_per_m.get(usize::from(block.axis)).copied();
        let path = path.path(block.f_hz);
        let one = Complex::new(1.0, 0.0);
        let unseen = (path.motion_sensor.inverse() - one).scale(pull.unwrap_or(0.0));
        for b in &mut self.blocks {
            let along = b.motion_m.get(usize::from(b.axis)).copied();
            b.force_n = b.force_n + unseen * along.unwrap_or(Complex::ZERO);
        }
        let part = 1.0 / BLOCKS as f32;
        let mean = |of: &dyn Fn(&Block) -> Complex<f32>| {
            self.blocks
                .iter()
                .fold(Complex::ZERO, |sum, b| sum + of(b))
                .scale(part)
        };
        let force = mean(&|b| b.force_n);
        let amplitude = force.abs();
        if !(amplitude > 0.0 && force.is_finite()) {
            return None;
        }
        let lag = path.force_lag;
        let mut out = LineResponse {
            axis: block.axis,
            line: block.line,
            f_hz: block.f_hz,
            force_n: amplitude * lag.abs(),
            trusted: self.blocks.iter().all(|b| b.trusted),
            ..LineResponse::default()
        };
        for k in 0..2 {
            let of = |b: &Block| b.motion_m.get(k).copied().unwrap_or(Complex::ZERO);
            let raw = mean(&of) * force.inverse();
            // What is left of each block, y − H·u: two numbers a block, two taken by H.
            let left: f32 = self
                .blocks
                .iter()
                .map(|b| (of(b) - raw * b.force_n).norm_sqr())
                .sum();
            let freedom = (2 * (BLOCKS - 1)) as f32;
            let sd = libm::sqrtf(left / freedom * part) / amplitude;
            let correct = path.correct(raw, block.f_hz);
            if !(correct.is_finite() && sd.is_finite()) {
                return None;
            }
            if let (Some(h), Some(s)) = (out.receptance.get_mut(k), out.sd.get_mut(k)) {
                *h = correct;
                *s = sd / (path.motion_sensor * lag).abs();
            }
        }
        Some(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cers::{BandNoise, BandNoiseConfig};

    const PATH: SensorPath = SensorPath {
        corner_hz: 10e3,
        eddy: None,
        pull_n_per_m: [0.0; 2],
    };

    fn block(n: u8, f_hz: f32, motion: Complex<f32>) -> Block {
        Block {
            axis: 1,
            line: 3,
            block: n,
            f_hz,
            force_n: Complex::new(3.0, 4.0),
            motion_m: [Complex::ZERO, motion],
            trusted: n != 2,
        }
    }

    #[test]
    fn sensor_is_taken_out_and_doubt_is_kept() {
        // At its corner a Butterworth sensor of second order gives −j/√2.
        let motion = Complex::new(3.0, 4.0) * Complex::new(0.0, -5e-9 * 0.5f32.sqrt());
        let mut collector = LineCollector::default();
        for n in 0..3 {
            assert_eq!(collector.add(&block(n, 10e3, motion), &PATH), None);
        }
        let line = collector.add(&block(3, 10e3, motion), &PATH).unwrap();
        assert!(
            (line.receptance[1] - Complex::new(5e-9, 0.0)).abs() < 1e-14,
            "{line:?}"
        );
        assert_eq!(
            (line.axis, line.line, line.force_n, line.trusted),
            (1, 3, 5.0, false)
        );
        assert_eq!(line.receptance[0], Complex::ZERO);
    }

    #[test]
    fn force_follows_the_gap_as_it_is() {
        // Seen −j/√2 of 10 nm at the corner; 0.2 N/µm times 10 nm less what was seen.
        let path = SensorPath {
            pull_n_per_m: [0.0, 0.2e6],
            ..PATH
        };
        let real = Complex::new(1e-8, 0.0);
        let seen = real * Complex::new(0.0, -(0.5f32.sqrt()));
        let mut collector = LineCollector::default();
        let line = (0..4)
            .map(|n| collector.add(&block(n, 10e3, seen), &path))
            .last();
        let line = line.flatten().unwrap();
        let force = Complex::new(3.0, 4.0) + (real - seen).scale(0.2e6);
        assert!(
            (line.receptance[1] - real * force.inverse()).abs() < 1e-14,
            "{line:?}"
        );
        assert!((line.force_n - force.abs()).abs() < 1e-5);
    }

    #[test]
    fn a_line_with_a_block_missing_is_no_line() {
        let mut collector = LineCollector::default();
        for n in [0, 1, 3] {
            assert_eq!(
                collector.add(&block(n, 1e3, Complex::new(1e-8, 0.0)), &PATH),
                None
            );
        }
    }

    #[test]
    fn deviations_are_those_of_the_draws() {
        let mut white = BandNoise::new(&BandNoiseConfig {
            rate_hz: 1000.0f32,
            low_hz: 0.0,
            high_hz: 450.0,
            seed: 5,
        })
        .unwrap();
        // Far enough apart to be independent.
        let mut draw = || (0..5).map(|_| 1e-8 * white.next_sample()).last().unwrap();
        let mut noise = || Complex::new(draw(), draw());
        let (mut square, mut stated) = (0.0f64, 0.0f64);
        let runs = 4000;
        for _ in 0..runs {
            let mut collector = LineCollector::default();
            let mut line = None;
            for n in 0..4 {
                line = collector.add(&block(n, 1.0, Complex::new(1e-7, 0.0) + noise()), &PATH);
            }
            let line = line.unwrap();
            let exact = Complex::new(1e-7, 0.0) * Complex::new(3.0, 4.0).inverse();
            square += f64::from((line.receptance[1] - exact).norm_sqr()) / 2.0;
            stated += f64::from(line.sd[1] * line.sd[1]);
        }
        let ratio = (square / stated).sqrt();
        assert!((0.96..1.04).contains(&ratio), "{ratio}");
    }
}
