//! Modes on which fits of several orders agree.

use rarma_core::real::Real;

/// A mode as one fit reads it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading<T> {
    /// Frequency, Hz.
    pub f_hz: T,
    /// Damping ratio, 1.
    pub zeta: T,
    /// Number of the fit, from 0.
    pub fit: u32,
}

/// A mode that many fits read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AgreedMode<T> {
    /// Median frequency, Hz.
    pub f_hz: T,
    /// Half the range that holds the middle half of the readings, Hz.
    pub f_spread_hz: T,
    /// Median damping ratio, 1.
    pub zeta: T,
    /// Half the range that holds the middle half, 1.
    pub zeta_spread: T,
    /// Fits that read it.
    pub fits: u32,
}

/// Groups readings of `fits` fits into modes and calls `found` for each that at least
/// half of the fits read, by rising frequency.
///
/// A spurious pole comes and goes with the order, a mode stays: so no single order has to
/// be chosen. Neighbours closer than `width` (relative, 0.01 is usual) belong together. The
/// spread is between orders, no standard deviation: it says how much the answer hangs on a
/// choice nobody can justify.
///
/// `readings` are sorted in place. O(n²).
pub fn agreed<T: Real>(
    readings: &mut [Reading<T>],
    fits: u32,
    width: T,
    mut found: impl FnMut(AgreedMode<T>),
) {
    sort(readings, |r| r.f_hz);
    let mut from = 0;
    while from < readings.len() {
        let mut to = from + 1;
        while to < readings.len()
            && readings[to].f_hz - readings[to - 1].f_hz <= width * readings[to].f_hz
        {
            to += 1;
        }
        let group = &mut readings[from..to];
        let mut seen = 0;
        for i in 0..group.len() {
            if group[..i].iter().all(|r| r.fit != group[i].fit) {
                seen += 1;
            }
        }
        if 2 * seen >= fits && seen > 0 {
            let (f_hz, f_spread_hz) = middle(group, |r| r.f_hz);
            let (zeta, zeta_spread) = middle(group, |r| r.zeta);
            found(AgreedMode {
                f_hz,
                f_spread_hz,
                zeta,
                zeta_spread,
                fits: seen,
            });
            sort(group, |r| r.f_hz);
        }
        from = to;
    }
}

fn sort<T: Real>(readings: &mut [Reading<T>], by: impl Fn(&Reading<T>) -> T) {
    for i in 1..readings.len() {
        let mut k = i;
        while k > 0 && by(&readings[k]) < by(&readings[k - 1]) {
            readings.swap(k, k - 1);
            k -= 1;
        }
    }
}

/// Median and half the distance of the quartiles.
fn middle<T: Real>(group: &mut [Reading<T>], by: impl Fn(&Reading<T>) -> T) -> (T, T) {
    sort(group, &by);
    let n = group.len();
    let half = T::from_f64(0.5);
    let median = (by(&group[(n - 1) / 2]) + by(&group[n / 2])) * half;
    let spread = (by(&group[n - 1 - n / 4]) - by(&group[n / 4])) * half;
    (median, spread)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_and_goes_is_left_out() {
        let mut readings = Vec::new();
        for fit in 0..7 {
            let off = f64::from(fit) - 3.0;
            let one = |f_hz, zeta| Reading { f_hz, zeta, fit };
            readings.push(one(1961.0 + off, 0.05));
            readings.push(one(1074.0 + off, 0.034 + 1e-3 * off));
            if fit > 4 {
                readings.push(one(1500.0 + off, 0.01));
            }
        }
        let mut modes = Vec::new();
        agreed(&mut readings, 7, 0.01, |m| modes.push(m));
        assert_eq!(modes.len(), 2);
        assert_eq!((modes[0].f_hz, modes[0].fits), (1074.0, 7));
        assert!((modes[0].zeta - 0.034).abs() < 1e-12);
        assert!((modes[0].f_spread_hz - 2.0).abs() < 1e-12);
        agreed::<f32>(&mut [], 3, 0.01, |_| panic!("nothing"));
    }
}
