//! Columns of stable poles over orders: what most models agree on.

use super::Candidate;
use serde::Serialize;

/// Poles further apart than this part of the frequency are of two clusters: the tolerance of a
/// stable frequency.
const APART: f64 = 0.01;
/// Candidates that agree at least.
const LEAST: usize = 3;

/// A mode that several candidates agree on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cluster {
    /// Median of the frequencies, Hz.
    pub f: f64,
    /// Least and largest, Hz.
    pub f_range: [f64; 2],
    /// Median of the damping ratios.
    pub zeta: f64,
    /// Least and largest.
    pub zeta_range: [f64; 2],
    /// Candidates in which it is stable.
    pub candidates: usize,
    /// The chosen candidate has a mode within the cluster, stable or not.
    pub chosen: bool,
}

/// The clusters of stable modes, by frequency: a gap of 1 % begins a new one, and three candidates
/// at least must agree.
pub(super) fn clusters(candidates: &[Candidate], choice: [usize; 2]) -> Vec<Cluster> {
    let mut stable: Vec<(f64, f64, [usize; 2])> = candidates
        .iter()
        .flat_map(|c| c.modes.iter().map(|m| (m, c.order)))
        .filter(|(m, _)| m.stable)
        .map(|(m, order)| (m.f, m.zeta, order))
        .collect();
    stable.sort_by(|a, b| a.0.total_cmp(&b.0));
    let chosen: Vec<f64> = candidates
        .iter()
        .filter(|c| c.order == choice)
        .flat_map(|c| c.modes.iter().map(|m| m.f))
        .collect();
    stable
        .chunk_by(|a, b| b.0 - a.0 <= APART * b.0)
        .filter_map(|group| {
            let mut orders: Vec<[usize; 2]> = group.iter().map(|m| m.2).collect();
            orders.sort_unstable();
            orders.dedup();
            let (f, f_range) = spread(group.iter().map(|m| m.0));
            let (zeta, zeta_range) = spread(group.iter().map(|m| m.1));
            let reach = APART * f;
            (orders.len() >= LEAST).then_some(Cluster {
                f,
                f_range,
                zeta,
                zeta_range,
                candidates: orders.len(),
                chosen: chosen
                    .iter()
                    .any(|x| (f_range[0] - reach..=f_range[1] + reach).contains(x)),
            })
        })
        .collect()
}

/// Where the clusters stand, Hz.
pub(in crate::commands) fn agreed(candidates: &[Candidate], choice: [usize; 2]) -> Vec<f64> {
    let found = clusters(candidates, choice);
    found.iter().map(|cluster| cluster.f).collect()
}

/// Median, least and largest.
fn spread(values: impl Iterator<Item = f64>) -> (f64, [f64; 2]) {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |k: usize| values.get(k).copied().unwrap_or(f64::NAN);
    let last = values.len().saturating_sub(1);
    (
        0.5 * (at(last / 2) + at(last.div_ceil(2))),
        [at(0), at(last)],
    )
}

#[cfg(test)]
mod tests {
    use super::super::CandidateMode;
    use super::*;

    fn candidate(p: usize, modes: &[(f64, f64, bool)]) -> Candidate {
        let mode = |&(f, zeta, stable): &(f64, f64, bool)| CandidateMode {
            f,
            f_sd: 1.0,
            zeta,
            zeta_sd: 0.001,
            stable_f: stable,
            stable,
        };
        Candidate {
            order: [p, p - 1],
            sigma2: 1.0,
            aic: 0.0,
            aicc: 0.0,
            bic: 0.0,
            fpe: 0.0,
            modes: modes.iter().map(mode).collect(),
        }
    }

    #[test]
    fn columns_are_found_and_lone_poles_are_not() {
        let all = [
            candidate(4, &[(100.0, 0.02, true), (300.0, 0.01, false)]),
            candidate(6, &[(100.4, 0.03, true), (150.0, 0.5, true)]),
            candidate(8, &[(99.8, 0.01, true), (301.0, 0.01, true)]),
            candidate(10, &[(250.0, 0.01, true), (303.0, 0.01, true)]),
        ];
        let found = clusters(&all, [8, 7]);
        assert_eq!(found.len(), 1, "{found:?}");
        let one = found[0];
        assert_eq!((one.f, one.zeta, one.candidates), (100.0, 0.02, 3));
        assert_eq!((one.f_range, one.zeta_range), ([99.8, 100.4], [0.01, 0.03]));
        assert!(one.chosen && !clusters(&all, [10, 9])[0].chosen);
    }
}
