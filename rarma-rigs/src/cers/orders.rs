//! What repeats with the spindle, taken out of a record: runout, unbalance, bearings.
//!
//! Rate: slow path, once a record.

use super::error::CersError;
use rarma_core::real::Real;
use rarma_fit::Triangle;

/// Takes the orders of a turning spindle out of a record in place:
///
/// ```text
/// x ← x − c₀ − Σ_k [c_k·cos(2π·o_k·φ) + s_k·sin(2π·o_k·φ)],   c, s by least squares
/// ```
///
/// φ are revolutions at each sample, from an index pulse or a constant speed: the speed may
/// change, the amplitudes are taken as constant over the record. The mean goes too. Lines
/// of the excitation must dodge the orders ([`Dodge`](super::Dodge)), or they lose power. `N`
/// ≥ 2·orders + 1. Gives the rms of what was taken, the mean apart.
///
/// # Errors
/// `DifferentLengths`; `AboveCapacity`; `TooFew` for less than twice as many samples as
/// unknowns; `NotFinite`; `Singular` for orders that cannot be told apart (a spindle that
/// stands, or a record of less than a revolution).
pub fn remove_orders<T: Real, const N: usize>(
    x: &mut [T],
    revolutions: &[T],
    orders: &[T],
) -> Result<T, CersError> {
    if x.len() != revolutions.len() {
        return Err(CersError::DifferentLengths);
    }
    let unknowns = 2 * orders.len() + 1;
    if unknowns > N {
        return Err(CersError::AboveCapacity);
    }
    if x.len() < 2 * unknowns {
        return Err(CersError::TooFew {
            needed: 2 * unknowns,
        });
    }
    let finite = |(x, r): (&T, &T)| x.is_finite() && r.is_finite();
    if let Some(index) = x.iter().zip(revolutions).position(|pair| !finite(pair)) {
        return Err(CersError::NotFinite { index });
    }
    let row = |revolution: T| {
        let mut out = [T::ZERO; N];
        out[0] = T::ONE;
        for (k, order) in orders.iter().enumerate() {
            // Whole turns out first: 1e5 revolutions cost single precision its phase.
            let turns = *order * revolution;
            let part = turns - turns.round();
            let (s, c) = (T::from_f64(2.0) * T::PI * part).sin_cos();
            (out[1 + 2 * k], out[2 + 2 * k]) = (c, s);
        }
        out
    };
    let mut triangle = Triangle::<T, N>::new(unknowns);
    for (x, revolution) in x.iter().zip(revolutions) {
        let _ = triangle.add(&mut row(*revolution), *x);
    }
    let found = triangle.solve().ok_or(CersError::Singular)?;
    let mut power = T::ZERO;
    for (x, revolution) in x.iter_mut().zip(revolutions) {
        let row = row(*revolution);
        let all: T = row.iter().zip(&found).map(|(a, b)| *a * *b).sum();
        let swing = all - found[0];
        power += swing * swing;
        *x -= all;
    }
    Ok((power / T::from_u32(x.len() as u32)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;

    #[test]
    fn orders_go_and_the_rest_stays() {
        // A speed that rises from 80 to 90 revolutions/s within the record.
        let n = 20_000;
        let t = |i: usize| i as f64 / 20e3;
        let turns: Vec<f64> = (0..n).map(|i| 80.0 * t(i) + 5.0 * t(i) * t(i)).collect();
        let rest: Vec<f64> = (0..n).map(|i| (TAU * 777.0 * t(i)).sin()).collect();
        let mut x: Vec<f64> = (0..n)
            .map(|i| {
                let a = TAU * turns[i];
                5.0 + 3.0 * (a + 0.3).cos() + (3.0 * a).sin() + rest[i]
            })
            .collect();
        let taken = remove_orders::<_, 9>(&mut x, &turns, &[1.0, 2.0, 3.0, 3.64]).unwrap();
        // 3²/2 + 1²/2 = 5.
        assert!((taken - f64::sqrt(5.0)).abs() < 0.01, "{taken}");
        let left = x
            .iter()
            .zip(&rest)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(left < 0.01, "{left}");
    }

    #[test]
    fn a_spindle_that_stands_is_refused() {
        let (mut x, still) = ([1.0; 100], [0.25; 100]);
        assert_eq!(
            remove_orders::<f64, 3>(&mut x, &still, &[1.0]),
            Err(CersError::Singular)
        );
        assert_eq!(
            remove_orders::<f64, 2>(&mut x, &still, &[1.0]),
            Err(CersError::AboveCapacity)
        );
        assert_eq!(
            remove_orders::<f64, 3>(&mut x, &still[1..], &[1.0]),
            Err(CersError::DifferentLengths)
        );
        let few = CersError::TooFew { needed: 6 };
        assert_eq!(
            remove_orders::<f64, 3>(&mut x[..5], &still[..5], &[1.0]),
            Err(few)
        );
    }
}
