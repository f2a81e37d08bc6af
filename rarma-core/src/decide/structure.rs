//! What the process does to a mode of the structure: the operational damping less
//! the modal one.
//!
//! Slow path. A hammer or an exciter at rest gives the modes of the structure alone;
//! in the cut the same modes carry the process as well. What is added is process
//! damping (ζ goes up), what is taken away is regeneration (ζ goes down, at zero it
//! chatters).

use super::mode::Mode;
use crate::real::Real;

/// Modes that a structure holds at most.
pub const MAX_STRUCTURAL_MODES: usize = 8;
/// An operational mode belongs to a structural one within this many joint standard
/// deviations of f ...
pub const STRUCTURE_SDS: f64 = 3.0;
/// ... or within this part of the structural f, whichever is more: in the cut a mode
/// moves by a few percent.
pub const STRUCTURE_WIDTH: f64 = 0.05;

/// One mode of the structure at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StructuralMode<T> {
    /// Undamped natural frequency, Hz, > 0.
    pub f_hz: T,
    /// Standard deviation of it, Hz, ≥ 0.
    pub f_sd: T,
    /// Modal damping ratio, −1 < ζ < 1. An estimate may fall below 0.
    pub zeta: T,
    /// Standard deviation of it, ≥ 0.
    pub zeta_sd: T,
}

/// Why a structure cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum StructureError {
    /// No mode at all.
    Empty,
    /// More than [`MAX_STRUCTURAL_MODES`].
    TooMany,
    /// The frequency of mode `0` must be positive and finite.
    Frequency(usize),
    /// The damping of mode `0` must lie between −1 and 1.
    Damping(usize),
    /// The standard deviations of mode `0` must be 0 or more, and finite.
    Deviation(usize),
}

/// The modes of a machine at rest.
///
/// ```
/// use rarma_core::decide::{Structure, StructuralMode};
/// let at_rest = StructuralMode { f_hz: 980.0, f_sd: 0.5, zeta: 0.020, zeta_sd: 0.0003 };
/// let structure = Structure::new(&[at_rest]).unwrap();
/// // In the cut: 1000 Hz ± 1, 0.8 % ± 0.04.
/// let process = structure.process_damping((1000.0, 1.0), (0.008, 0.0004)).unwrap();
/// assert!((process.zeta + 0.012f64).abs() < 1e-12 && (process.zeta_sd - 0.0005).abs() < 1e-12);
/// assert!(process.significance < -23.0);
/// assert!(structure.process_damping((1100.0, 1.0), (0.008, 0.0004)).is_none());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Structure<T> {
    modes: [StructuralMode<T>; MAX_STRUCTURAL_MODES],
    count: usize,
}

/// The part of the process in the damping of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProcessDamping<T> {
    /// ζ_process = ζ_operational − ζ_modal; negative where the process feeds the
    /// vibration.
    pub zeta: T,
    /// √(sd_operational² + sd_modal²).
    pub zeta_sd: T,
    /// ζ_process in standard deviations, sign kept; 0 where there is no deviation
    /// to measure by.
    pub significance: T,
    /// Place of the structural mode in the list.
    pub mode: usize,
}

impl<T: Real> Structure<T> {
    /// Keeps the modes.
    ///
    /// # Errors
    /// The first mode that is out of range, or their number.
    pub fn new(modes: &[StructuralMode<T>]) -> Result<Self, StructureError> {
        let first = *modes.first().ok_or(StructureError::Empty)?;
        let mut kept = [first; MAX_STRUCTURAL_MODES];
        for (i, mode) in modes.iter().enumerate() {
            if !(mode.f_hz > T::ZERO && mode.f_hz.is_finite()) {
                return Err(StructureError::Frequency(i));
            }
            if !(mode.zeta.abs() < T::ONE) {
                return Err(StructureError::Damping(i));
            }
            let valid = |sd: T| sd >= T::ZERO && sd.is_finite();
            if !valid(mode.f_sd) || !valid(mode.zeta_sd) {
                return Err(StructureError::Deviation(i));
            }
            *kept.get_mut(i).ok_or(StructureError::TooMany)? = *mode;
        }
        Ok(Self {
            modes: kept,
            count: modes.len(),
        })
    }

    /// The modes.
    pub fn modes(&self) -> &[StructuralMode<T>] {
        self.modes.get(..self.count).unwrap_or(&self.modes)
    }

    /// The process in an operational mode: `frequency` (Hz) and `damping` (1), each
    /// with its standard deviation. The structural mode is the nearest one within
    /// [`STRUCTURE_SDS`]·√(sd² + sd²) of f or [`STRUCTURE_WIDTH`] of its own f, whichever is
    /// more; none where no structural mode is there, or for what is no number.
    pub fn process_damping(&self, frequency: (T, T), damping: (T, T)) -> Option<ProcessDamping<T>> {
        let joint = |a: T, b: T| (a * a + b * b).sqrt();
        let mut nearest: Option<(usize, &StructuralMode<T>, T)> = None;
        for (i, mode) in self.modes().iter().enumerate() {
            let off = (frequency.0 - mode.f_hz).abs();
            let width = (mode.f_hz * T::from_f64(STRUCTURE_WIDTH))
                .max(joint(frequency.1, mode.f_sd) * T::from_f64(STRUCTURE_SDS));
            if off <= width && nearest.is_none_or(|(_, _, least)| off < least) {
                nearest = Some((i, mode, off));
            }
        }
        let (i, mode, _) = nearest?;
        let zeta = damping.0 - mode.zeta;
        let zeta_sd = joint(damping.1, mode.zeta_sd);
        if !(zeta.is_finite() && zeta_sd.is_finite() && frequency.1.is_finite()) {
            return None;
        }
        Some(ProcessDamping {
            zeta,
            zeta_sd,
            significance: if zeta_sd > T::ZERO {
                zeta / zeta_sd
            } else {
                T::ZERO
            },
            mode: i,
        })
    }

    /// The process in a mode of a report; see [`Self::process_damping`].
    pub fn process_of(&self, mode: &Mode<T>) -> Option<ProcessDamping<T>> {
        self.process_damping(
            (mode.frequency, mode.frequency_sd),
            (mode.damping, mode.damping_sd),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(f_hz: f64, f_sd: f64, zeta: f64) -> StructuralMode<f64> {
        StructuralMode {
            f_hz,
            f_sd,
            zeta,
            zeta_sd: 0.0005,
        }
    }

    #[test]
    fn nearest_mode_within_the_width() {
        let structure = Structure::new(&[at(900.0, 1.0, 0.03), at(960.0, 1.0, 0.02)]).unwrap();
        let read = |f, f_sd| structure.process_damping((f, f_sd), (0.01, 0.001));
        // Five percent of 900 is 45 Hz, of 960 it is 48 Hz; between them the nearer.
        assert_eq!(read(856.0, 1.0).unwrap().mode, 0);
        assert!(read(854.0, 1.0).is_none());
        assert_eq!(read(929.0, 1.0).unwrap().mode, 0);
        assert_eq!(read(931.0, 1.0).unwrap().mode, 1);
        assert!(read(1009.0, 1.0).is_none());
        // Three joint deviations reach further: 3·√(20² + 1²) = 60 Hz.
        assert_eq!(read(1019.0, 20.0).unwrap().mode, 1);
        assert!(read(1021.0, 20.0).is_none());
        let process = read(900.0, 1.0).unwrap();
        assert!((process.zeta + 0.02).abs() < 1e-12);
        assert!((process.zeta_sd - 1.25e-6f64.sqrt()).abs() < 1e-12);
        assert!((process.significance + 0.02 / 1.25e-6f64.sqrt()).abs() < 1e-9);
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(read(bad, 1.0).is_none());
            assert!(
                structure
                    .process_damping((900.0, 1.0), (bad, 0.1))
                    .is_none()
            );
            assert!(
                structure
                    .process_damping((900.0, 1.0), (0.1, bad))
                    .is_none()
            );
        }
    }

    #[test]
    fn out_of_range_is_named() {
        let good = at(900.0, 1.0, 0.03);
        let with = |bad: StructuralMode<f64>| Structure::new(&[good, bad]).unwrap_err();
        assert_eq!(Structure::<f64>::new(&[]), Err(StructureError::Empty));
        assert_eq!(
            Structure::new(&[good; 9]).unwrap_err(),
            StructureError::TooMany
        );
        assert_eq!(Structure::new(&[good; 8]).unwrap().modes().len(), 8);
        for f_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(
                with(StructuralMode { f_hz, ..good }),
                StructureError::Frequency(1)
            );
        }
        for zeta in [1.0, -1.0, f64::NAN] {
            assert_eq!(
                with(StructuralMode { zeta, ..good }),
                StructureError::Damping(1)
            );
        }
        for sd in [-1e-9, f64::NAN, f64::INFINITY] {
            assert_eq!(
                with(StructuralMode { f_sd: sd, ..good }),
                StructureError::Deviation(1)
            );
            assert_eq!(
                with(StructuralMode {
                    zeta_sd: sd,
                    ..good
                }),
                StructureError::Deviation(1)
            );
        }
    }
}
