//! Machine errors of a circle by least squares.

use super::error::LdbbError;
use super::terms::{Circle, MAX_TERMS, Sense, Terms};
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Sectors of the circle that are watched for cover.
const SECTORS: usize = 72;
/// Errors that leave the unknowns further apart than this are no answer.
const MOST_CONDITION: f64 = 1e3;

/// A value and its standard deviation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Measured<T> {
    /// Value.
    pub value: T,
    /// Standard deviation.
    pub sd: T,
}

/// The errors of a machine in one plane, SI. What one direction or part of a circle
/// does not determine is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineErrors<T> {
    /// Mean radius less the nominal one, m; means something with a calibrated length only.
    pub radius_m: Measured<T>,
    /// Centre, m.
    pub centre_m: [Measured<T>; 2],
    /// Travel of X less that of Y over the diameter, m: 2R(sx − sy).
    pub scale_mismatch_m: Measured<T>,
    /// Squareness, rad; positive where +X and +Y are more than 90° apart.
    pub squareness_rad: Measured<T>,
    /// The squareness holds the servo mismatch v(τx − τy)/R as well, with the run's
    /// sign.
    pub squareness_includes_servo: bool,
    /// Straightness of X, Y, m: 4·S3, −4·C3.
    pub straightness_m: Option<[Measured<T>; 2]>,
    /// Backlash of X, Y, m.
    pub backlash_m: Option<[Measured<T>; 2]>,
    /// Lateral play of X, Y, m.
    pub lateral_play_m: Option<[Measured<T>; 2]>,
    /// Servo mismatch τx − τy, s.
    pub servo_mismatch_s: Option<Measured<T>>,
    /// Amplitude of the cyclic error of X, Y, m.
    pub cyclic_m: Option<[Measured<T>; 2]>,
    /// Scatter of the readings about the fit, m.
    pub scatter_m: T,
    /// Condition of the equations (Frobenius, over the number of unknowns).
    pub condition: T,
    /// Readings.
    pub readings: u32,
}

/// Takes readings one at a time.
///
/// Readings are in m and the columns of order 1: the triangle has the condition of the
/// equations, which single precision bears (Δr, not r).
#[derive(Debug, Clone)]
pub struct ErrorFit<T> {
    terms: Terms,
    circle: Circle<T>,
    triangle: Triangle<T, MAX_TERMS>,
    squares: T,
    readings: u32,
    covered: [bool; SECTORS],
    senses: [bool; 2],
}

impl<T: Real> ErrorFit<T> {
    /// No readings.
    ///
    /// # Errors
    /// `OutOfRange`: radius or feed not positive, or a cyclic error is asked for without
    /// a pitch.
    pub fn new(terms: Terms, circle: Circle<T>) -> Result<Self, LdbbError> {
        let name = if !(circle.radius_m > T::ZERO) {
            "radius"
        } else if !(circle.feed_m_s > T::ZERO) {
            "feed"
        } else if terms.cyclic && !(circle.pitch_m > T::ZERO) {
            "pitch"
        } else {
            return Ok(Self {
                terms,
                circle,
                triangle: Triangle::new(terms.count()),
                squares: T::ZERO,
                readings: 0,
                covered: [false; SECTORS],
                senses: [false; 2],
            });
        };
        Err(LdbbError::OutOfRange { name })
    }

    /// Takes a reading: θ, rad, and Δr, m.
    ///
    /// # Errors
    /// `NotFinite`, with the number of readings before it; nothing is taken then.
    pub fn add(&mut self, theta: T, sense: Sense, dr_m: T) -> Result<(), LdbbError> {
        if !(theta.is_finite() && dr_m.is_finite()) {
            return Err(LdbbError::NotFinite {
                index: self.readings as usize,
            });
        }
        let mut row = self.terms.row(theta, sense, &self.circle);
        let rest = self.triangle.add(&mut row, dr_m);
        self.squares += rest * rest;
        self.readings += 1;
        self.senses[usize::from(sense == Sense::Cw)] = true;
        let turns = theta.to_f32() / core::f32::consts::TAU;
        let part = turns - libm::floorf(turns);
        if let Some(sector) = self.covered.get_mut((part * SECTORS as f32) as usize) {
            *sector = true;
        }
        Ok(())
    }

    /// How much of the circle has readings, degrees.
    pub fn covered_deg(&self) -> f32 {
        let sectors = self.covered.iter().filter(|c| **c).count();
        sectors as f32 * (360.0 / SECTORS as f32)
    }

    /// The errors, with their standard deviations from the scatter of the readings.
    ///
    /// # Errors
    /// `ShortArc` below 180°; `TooFew`; `Singular` where the readings do not determine the
    /// terms: one direction asked for twelve, or part of a circle for nine.
    pub fn solve(&self) -> Result<MachineErrors<T>, LdbbError> {
        let n = self.terms.count();
        let covered_deg = self.covered_deg();
        if covered_deg < 180.0 {
            return Err(LdbbError::ShortArc { covered_deg });
        }
        if (self.readings as usize) < 2 * n {
            return Err(LdbbError::TooFew { needed: 2 * n });
        }
        let both = self.senses[0] && self.senses[1];
        let most = Terms::of(both, covered_deg, self.terms.cyclic);
        if self.terms.machine > most.machine || (self.terms.cyclic && !most.cyclic) {
            return Err(LdbbError::Singular);
        }
        let x = self.triangle.solve().ok_or(LdbbError::Singular)?;
        let inverse = self.triangle.inverse_normal().ok_or(LdbbError::Singular)?;
        let (mut columns, mut trace) = (T::ZERO, T::ZERO);
        for (i, row) in inverse.iter().enumerate().take(n) {
            let length = self.triangle.column(i);
            columns += length * length;
            trace += row[i];
        }
        let condition = (columns * trace).sqrt() / T::from_u32(n as u32);
        if !(condition < T::from_f64(MOST_CONDITION)) {
            return Err(LdbbError::Singular);
        }
        let variance = self.squares / T::from_u32(self.readings - n as u32);
        Ok(self.named(&x, &inverse, variance, condition))
    }

    fn named(
        &self,
        x: &[T; MAX_TERMS],
        inverse: &[[T; MAX_TERMS]; MAX_TERMS],
        variance: T,
        condition: T,
    ) -> MachineErrors<T> {
        let of = |k: usize, scale: T| Measured {
            value: scale * x[k],
            sd: scale.abs() * (variance * inverse[k][k]).sqrt(),
        };
        let one = T::ONE;
        let (two, four) = (T::from_f64(2.0), T::from_f64(4.0));
        let (radius, feed) = (self.circle.radius_m, self.circle.feed_m_s);
        let has = |k: usize| self.terms.machine > k;
        let cyclic = |at: usize| {
            let (p, q) = (x[at], x[at + 1]);
            let value = (p * p + q * q).sqrt();
            // Along the amplitude; where there is none, any direction does.
            let (up, uq) = if value > T::ZERO {
                (p / value, q / value)
            } else {
                (one, T::ZERO)
            };
            let spread = up * up * inverse[at][at]
                + two * up * uq * inverse[at][at + 1]
                + uq * uq * inverse[at + 1][at + 1];
            Measured {
                value,
                sd: (variance * spread).sqrt(),
            }
        };
        let first = self.terms.machine;
        MachineErrors {
            radius_m: of(0, one),
            centre_m: [of(1, one), of(2, one)],
            scale_mismatch_m: of(3, four),
            squareness_rad: of(4, -two / radius),
            squareness_includes_servo: !has(11),
            straightness_m: has(6).then(|| [of(6, four), of(5, -four)]),
            backlash_m: has(8).then(|| [of(7, one), of(8, one)]),
            lateral_play_m: has(10).then(|| [of(9, one), of(10, one)]),
            servo_mismatch_s: has(11).then(|| of(11, two / feed)),
            cyclic_m: self
                .terms
                .cyclic
                .then(|| [cyclic(first), cyclic(first + 2)]),
            scatter_m: variance.sqrt(),
            condition,
            readings: self.readings,
        }
    }

    /// What the fit says at θ, m; 0 where there is none.
    pub fn predicted(&self, theta: T, sense: Sense) -> T {
        let Some(x) = self.triangle.solve() else {
            return T::ZERO;
        };
        let row = self.terms.row(theta, sense, &self.circle);
        row.iter().zip(&x).map(|(a, b)| *a * *b).sum()
    }
}
