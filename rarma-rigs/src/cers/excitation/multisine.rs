//! Periodic signals of many lines, with phases that keep the peaks down.
//!
//! Rate: slow path; a table of one period is made once and then read sample by sample.

use super::lines::Lines;
use crate::cers::error::CersError;
use crate::cers::spectra::RealFft;
use crate::els::Complex;
use rarma_core::real::Real;

/// Phases of the lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phases {
    /// Schroeder's: φ_j = −π·j(j − 1)/K for the j-th of K lines. Good for lines that
    /// follow each other.
    Schroeder,
    /// Random, from a seed.
    Random(u32),
}

/// One period of Σ a_k·cos(2πk·n/N + φ_k) over the lines, a_k from `amplitude(Hz)`, scaled
/// to unit rms, into `out` of N = 2·M samples.
///
/// # Errors
/// `DifferentLengths` if `out` is not 2·M long; `AboveCapacity` if a line is not below M;
/// `OutOfRange` if no amplitude is above 0.
pub fn multisine<T: Real, const M: usize>(
    lines: &Lines<T>,
    phases: Phases,
    amplitude: impl Fn(T) -> T,
    fft: &mut RealFft<T, M>,
    out: &mut [T],
) -> Result<(), CersError> {
    if out.len() != 2 * M {
        return Err(CersError::DifferentLengths);
    }
    if lines.last() >= M {
        return Err(CersError::AboveCapacity);
    }
    let count = lines.count() as f64;
    let mut seed = match phases {
        Phases::Random(seed) => (seed ^ 0x9e37_79b9) | 1,
        Phases::Schroeder => 1,
    };
    out.fill(T::ZERO);
    let mut power = T::ZERO;
    for (j, k) in lines.iter().enumerate() {
        let turns = match phases {
            Phases::Schroeder => {
                let j = (j + 1) as f64;
                let t = j * (j - 1.0) / (2.0 * count);
                -(t - libm::floor(t))
            }
            Phases::Random(_) => {
                seed ^= seed << 13;
                seed ^= seed >> 17;
                seed ^= seed << 5;
                f64::from(seed) / 4_294_967_296.0
            }
        };
        let a = amplitude(lines.hz(k));
        power += a * a * T::from_f64(0.5);
        let (s, c) = T::from_f64(core::f64::consts::TAU * turns).sin_cos();
        RealFft::<T, M>::put_line(out, k, Complex::new(c, s).scale(a));
    }
    if !(power > T::ZERO) {
        return Err(CersError::OutOfRange { name: "amplitude" });
    }
    fft.synthesise(out)?;
    let gain = T::ONE / power.sqrt();
    for x in out {
        *x *= gain;
    }
    Ok(())
}

/// Largest magnitude over the rms.
pub fn crest_factor<T: Real>(x: &[T]) -> T {
    let (mut most, mut square) = (T::ZERO, T::ZERO);
    for x in x {
        most = most.max(x.abs());
        square += *x * *x;
    }
    most / (square / T::from_u32(x.len().max(1) as u32)).sqrt()
}

/// Lowers the crest factor of a period made by [`multisine`], amplitudes unchanged: clips,
/// keeps the phases of what is left, gives the lines their amplitudes back, and again. The
/// best period found stays in `period`; gives its crest factor.
///
/// `work` is as long as `period`. 600 rounds bring 1.66 to 1.47 (500 of 2048 lines); do it off the box.
///
/// # Errors
/// `DifferentLengths`; `AboveCapacity` as [`multisine`].
pub fn lower_crest<T: Real, const M: usize>(
    lines: &Lines<T>,
    rounds: u32,
    fft: &mut RealFft<T, M>,
    period: &mut [T],
    work: &mut [T],
) -> Result<T, CersError> {
    if period.len() != 2 * M || work.len() != 2 * M {
        return Err(CersError::DifferentLengths);
    }
    if lines.last() >= M {
        return Err(CersError::AboveCapacity);
    }
    let mut best = crest_factor(period);
    work.copy_from_slice(period);
    // From hardly at all to far: a hard clip at once ends in a worse minimum.
    for round in 0..rounds {
        let part = T::from_u32(round) / T::from_u32(rounds);
        let level = T::from_f64(0.95) - T::from_f64(0.2) * part;
        let most = work.iter().fold(T::ZERO, |m, x| m.max(x.abs())) * level;
        for x in work.iter_mut() {
            *x = x.clamp(-most, most);
        }
        fft.exchange_phases(lines.iter(), period, work)?;
        let now = crest_factor(work);
        if now < best {
            best = now;
            period.copy_from_slice(work);
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cers::excitation::{Dodge, LineSet};
    use crate::cers::spectra::tests::powers;

    const M: usize = 2048;

    fn made(lines: &Lines<f64>, phases: Phases) -> (Vec<f64>, RealFft<f64, M>) {
        let mut fft = RealFft::default();
        let mut x = vec![0.0; 2 * M];
        multisine(lines, phases, |_| 1.0, &mut fft, &mut x).unwrap();
        (x, fft)
    }

    fn lines(count: usize, set: LineSet, dodge: Option<Dodge<f64>>) -> Lines<f64> {
        let spacing = 20e3 / 4096.0;
        Lines::new(spacing, (spacing, spacing * count as f64), set, dodge).unwrap()
    }

    #[test]
    fn schroeder_has_the_published_crest_factor() {
        for count in [250, 500, 1000] {
            let l = lines(count, LineSet::All, None);
            let (x, _) = made(&l, Phases::Schroeder);
            let crest = crest_factor(&x);
            let (r, _) = made(&l, Phases::Random(5));
            println!(
                "{count} lines: Schroeder {crest:.3}, random {:.2}",
                crest_factor(&r)
            );
            // Published 1.82 to 1.90, on a finer grid of time.
            assert!((1.6..1.92).contains(&crest), "{count}: {crest}");
            assert!((3.0..5.0).contains(&crest_factor(&r)));
            let rms = (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
            assert!((rms - 1.0).abs() < 1e-9, "{rms}");
        }
    }

    #[test]
    fn rounds_of_clipping_lower_it_and_leave_the_lines_alone() {
        let l = lines(500, LineSet::All, None);
        let (mut x, mut fft) = made(&l, Phases::Schroeder);
        let before = powers::<M>(&x);
        let mut work = vec![0.0; 2 * M];
        let crest = lower_crest(&l, 600, &mut fft, &mut x, &mut work).unwrap();
        println!("600 rounds: {crest:.3}");
        assert!((1.35..1.55).contains(&crest), "{crest}");
        assert!((crest_factor(&x) - crest).abs() < 1e-12);
        let after = powers::<M>(&x);
        for k in 0..M {
            let due = if l.has(k) { before[k] } else { 0.0 };
            assert!((after[k] - due).abs() < 1e-6 * before[10], "{k}");
        }
    }

    #[test]
    fn two_directions_are_orthogonal_and_dodge_the_spindle() {
        let dodge = Some(Dodge {
            spindle_hz: 5000.0 / 60.0,
            clearance_hz: 3.0,
        });
        let (odd, even) = (
            lines(1000, LineSet::Odd, dodge),
            lines(1000, LineSet::Even, dodge),
        );
        let (x, y) = (
            powers::<M>(&made(&odd, Phases::Schroeder).0),
            powers::<M>(&made(&even, Phases::Schroeder).0),
        );
        let top = x.iter().copied().fold(0.0, f64::max);
        let both = x
            .iter()
            .zip(&y)
            .map(|(a, b)| (a * b).sqrt())
            .fold(0.0, f64::max);
        println!(
            "common part of both spectra: {:.1e} of the largest line",
            both / top
        );
        assert!(both < 1e-10 * top);
        for k in 1..M {
            let f = 20e3 / 4096.0 * k as f64;
            let order = (f / (5000.0 / 60.0)).round();
            if order >= 1.0 && (f - order * 5000.0 / 60.0).abs() <= 3.0 {
                assert!(x[k] + y[k] < 1e-10 * top, "{f}");
            }
        }
    }

    #[test]
    fn amplitudes_follow_the_shape() {
        let l = lines(1000, LineSet::All, None);
        let mut fft = RealFft::<f64, M>::default();
        let mut x = vec![0.0; 2 * M];
        let shape = |f: f64| if f > 2300.0 { 2300.0 / f } else { 1.0 };
        multisine(&l, Phases::Schroeder, shape, &mut fft, &mut x).unwrap();
        let p = powers::<M>(&x);
        for k in [100, 470, 600, 900] {
            let due = shape(l.hz(k)) / shape(l.hz(10));
            assert!(((p[k] / p[10]).sqrt() / due - 1.0).abs() < 1e-9, "{k}");
        }
    }

    #[test]
    fn refusals() {
        let l = lines(500, LineSet::All, None);
        let mut fft = RealFft::<f64, 256>::default();
        let mut short = vec![0.0; 512];
        let of = |r: Result<(), CersError>| r.unwrap_err();
        assert_eq!(
            of(multisine(
                &l,
                Phases::Schroeder,
                |_| 1.0,
                &mut fft,
                &mut short
            )),
            CersError::AboveCapacity
        );
        assert_eq!(
            of(multisine(
                &l,
                Phases::Schroeder,
                |_| 1.0,
                &mut fft,
                &mut short[..100]
            )),
            CersError::DifferentLengths
        );
    }
}
