//! Which modes of a model persist from the model one order below.
//!
//! Slow path. A mode of the structure stays where it is when the order rises; what a
//! model of too high an order makes up out of noise moves. Shown over orders, that is
//! the stabilisation diagram of modal analysis.

use rarma_core::real::Real;
use rarma_core::spectrum::Modal;

/// How much a mode may move and still be the same.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilisationConfig<T> {
    /// Largest |Δf|/f, 1; 1e-6..=0.5, default 0.01. Takes effect at the next call.
    pub frequency: T,
    /// Largest |Δζ|/ζ, 1; 1e-6..=10, default 0.05. Takes effect at the next call. A
    /// setting below the difference that noise makes leaves true modes out.
    pub damping: T,
}

impl<T: Real> Default for StabilisationConfig<T> {
    fn default() -> Self {
        Self {
            frequency: T::from_f64(0.01),
            damping: T::from_f64(0.05),
        }
    }
}

/// What became of a mode from one order to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Stability {
    /// No mode of the model below lies within the tolerance of frequency.
    #[default]
    New,
    /// Frequency within tolerance, damping not.
    Frequency,
    /// Frequency and damping within tolerance.
    Stable,
}

/// Why modes cannot be compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StabilisationError {
    /// A tolerance is out of its range.
    OutOfRange,
    /// `out` is not as long as `modes`.
    DifferentLengths,
    /// More than 64 modes in a model.
    TooManyModes,
}

impl core::fmt::Display for StabilisationError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::OutOfRange => "a tolerance is out of its range",
            Self::DifferentLengths => "one mark for each mode is needed",
            Self::TooManyModes => "more than 64 modes",
        })
    }
}

impl core::error::Error for StabilisationError {}

/// Modes of a model at most.
const MOST: usize = 64;

/// Says of each of `modes` whether it persists from `below`, the modes of the model
/// one order step lower; `out` is as long as `modes`.
///
/// ```text
/// stable:  |f − f′| < frequency·f  and  |ζ − ζ′| < damping·|ζ|
/// ```
///
/// A mode of `below` counts once: pairs are made from the nearest in frequency on, in
/// parts of f, so a mode that splits has one part that is new. Modes that are not
/// finite, or have no frequency, are new. Order of the modes: any.
///
/// ```
/// use rarma_core::spectrum::Modal;
/// use rarma_fit::{Stability, StabilisationConfig, stabilise};
/// let mode = |frequency: f64, damping| Modal { frequency, damping };
/// let below = [mode(980.0, 0.020), mode(450.0, 0.030)];
/// let modes = [mode(450.2, 0.038), mode(979.0, 0.0203), mode(1700.0, 0.1)];
/// let mut out = [Stability::New; 3];
/// stabilise(&StabilisationConfig::default(), &below, &modes, &mut out)?;
/// assert_eq!(out, [Stability::Frequency, Stability::Stable, Stability::New]);
/// # Ok::<(), rarma_fit::StabilisationError>(())
/// ```
///
/// # Errors
/// See [`StabilisationError`]; `out` is then untouched.
pub fn stabilise<T: Real>(
    config: &StabilisationConfig<T>,
    below: &[Modal<T>],
    modes: &[Modal<T>],
    out: &mut [Stability],
) -> Result<(), StabilisationError> {
    let within = |x: T, most: f64| x >= T::from_f64(1e-6) && x <= T::from_f64(most);
    if !within(config.frequency, 0.5) || !within(config.damping, 10.0) {
        return Err(StabilisationError::OutOfRange);
    }
    if out.len() != modes.len() {
        return Err(StabilisationError::DifferentLengths);
    }
    if below.len().max(modes.len()) > MOST {
        return Err(StabilisationError::TooManyModes);
    }
    out.fill(Stability::New);
    let (mut used, mut matched) = (0u64, 0u64);
    for _ in 0..modes.len() {
        let mut best: Option<(usize, usize, T)> = None;
        for (i, mode) in modes.iter().enumerate() {
            for (j, other) in below.iter().enumerate() {
                let free = matched >> i & 1 == 0 && used >> j & 1 == 0;
                let apart = (mode.frequency - other.frequency).abs();
                let part = apart / mode.frequency;
                let near = mode.frequency > T::ZERO && part < config.frequency;
                if free && near && best.is_none_or(|(_, _, b)| part < b) {
                    best = Some((i, j, part));
                }
            }
        }
        let Some((i, j, _)) = best else { break };
        matched |= 1 << i;
        used |= 1 << j;
        let (zeta, before) = (modes[i].damping, below[j].damping);
        out[i] = if (zeta - before).abs() < config.damping * zeta.abs() {
            Stability::Stable
        } else {
            Stability::Frequency
        };
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn mode(frequency: f32, damping: f32) -> Modal<f32> {
        Modal { frequency, damping }
    }

    fn marks<const M: usize>(below: &[Modal<f32>], modes: &[Modal<f32>; M]) -> [Stability; M] {
        let mut out = [Stability::Stable; M];
        stabilise(&StabilisationConfig::default(), below, modes, &mut out).expect("valid");
        out
    }

    #[test]
    fn a_mode_below_counts_once_and_the_nearest_gets_it() {
        let below = [mode(1000.0, 0.02)];
        let split = [mode(995.0, 0.02), mode(1001.0, 0.02)];
        assert_eq!(marks(&below, &split), [Stability::New, Stability::Stable]);
        // 1001 belongs to 1002, so 995 gets what is left.
        let below = [mode(1000.0, 0.02), mode(1002.0, 0.02)];
        assert_eq!(
            marks(&below, &split),
            [Stability::Stable, Stability::Stable]
        );
    }

    #[test]
    fn tolerances_hold_on_both_sides() {
        let below = [mode(1000.0, 0.02)];
        for (f, zeta, want) in [
            (1009.0, 0.0209, Stability::Stable),
            (991.0, 0.0191, Stability::Stable),
            (1011.0, 0.02, Stability::New),
            (989.0, 0.02, Stability::New),
            (1000.0, 0.0212, Stability::Frequency),
            (1000.0, 0.0189, Stability::Frequency),
            (f32::NAN, 0.02, Stability::New),
            (1000.0, f32::NAN, Stability::Frequency),
            (0.0, 0.02, Stability::New),
        ] {
            assert_eq!(marks(&below, &[mode(f, zeta)]), [want], "{f} {zeta}");
        }
        assert_eq!(marks(&[], &[mode(1.0, 0.1)]), [Stability::New]);
    }

    #[test]
    fn refusals_name_their_cause() {
        let config = StabilisationConfig::default();
        let modes = [mode(1.0, 0.1); 65];
        let run = |config: &_, n: usize, out: usize| {
            stabilise(config, &[], &modes[..n], &mut [Stability::New; 65][..out])
        };
        assert_eq!(
            run(&config, 2, 1),
            Err(StabilisationError::DifferentLengths)
        );
        assert_eq!(run(&config, 65, 65), Err(StabilisationError::TooManyModes));
        for (frequency, damping) in [(0.0, 0.05), (0.6, 0.05), (0.01, f32::NAN), (0.01, 11.0)] {
            let config = StabilisationConfig { frequency, damping };
            assert_eq!(run(&config, 2, 2), Err(StabilisationError::OutOfRange));
        }
    }

    proptest! {
        #[test]
        fn a_model_is_stable_against_itself_and_order_does_not_matter(
            f in prop::collection::vec(1.0f32..5000.0, 1..12), turn in 0usize..12,
        ) {
            let modes: Vec<_> = f.iter().map(|f| mode(*f, 0.02)).collect();
            let mut below = modes.clone();
            below.rotate_left(turn % modes.len());
            let mut out = vec![Stability::New; modes.len()];
            stabilise(&StabilisationConfig::default(), &below, &modes, &mut out).expect("valid");
            prop_assert!(out.iter().all(|x| *x == Stability::Stable));
        }
    }
}
