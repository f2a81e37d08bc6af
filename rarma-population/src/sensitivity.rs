//! What half and double of each number of the verdict do.

use super::detectors::{ALL, Recording, named};
use super::score::{Score, Sum, judge};
use crate::Defect;
use rarma_core::verdict::{Number, VerdictConfig};
use rarma_plants::population::Cut;
use rarma_plants::population::heard::Heard;

/// Numbers of which one is not the usual.
#[derive(Debug, Clone, Copy)]
pub struct Variant {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// All of them.
    pub numbers: VerdictConfig,
}

/// Half and double of every number; one less and one more where the usual is zero. What lies
/// out of range is held at its end.
pub fn variants(usual: &VerdictConfig) -> Vec<Variant> {
    let mut all = Vec::new();
    for &Number {
        name, least, most, ..
    } in VerdictConfig::NUMBERS
    {
        let Some(x) = usual.get(name) else {
            continue;
        };
        let others = if x == 0.0 {
            [-1.0, 1.0]
        } else {
            [0.5 * x, 2.0 * x]
        };
        for value in others.map(|value| value.clamp(least, most)) {
            let mut numbers = *usual;
            if value != x && numbers.set(name, value).is_ok() {
                all.push(Variant {
                    name,
                    value,
                    numbers,
                });
            }
        }
    }
    all
}

/// What each of them makes of a recording: its scores.
///
/// # Errors
/// The recording does not suit the verdict: a defect of the population.
pub fn scores(
    cut: &Cut,
    heard: &Heard,
    recording: &Recording,
    variants: &[Variant],
) -> Result<Vec<Score>, Defect> {
    let verdict = named("verdict").map(|place| ALL[place]);
    let mut all = Vec::new();
    for variant in variants {
        let mut changed = recording.clone();
        changed.numbers = variant.numbers;
        let said = match verdict {
            Some(verdict) => verdict.listen(&changed, &[variant.numbers.call])?,
            None => Vec::new(),
        };
        all.extend(said.iter().map(|said| judge(cut, heard, said, 0.0)));
    }
    Ok(all)
}

/// A variant's row: its name, the usual value and its own, and what it reaches.
pub fn cells(variant: &Variant, usual: &VerdictConfig, sum: &Sum) -> Vec<String> {
    let mut row = vec![
        variant.name.to_owned(),
        usual.get(variant.name).unwrap_or_default().to_string(),
        variant.value.to_string(),
    ];
    row.extend(sum.cells());
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_is_changed_both_ways_and_alone() {
        let usual = VerdictConfig::default();
        let all = variants(&usual);
        for Number { name, .. } in VerdictConfig::NUMBERS {
            let of_it: Vec<&Variant> = all.iter().filter(|v| v.name == *name).collect();
            assert!(!of_it.is_empty(), "{name}");
            for variant in of_it {
                let mut back = variant.numbers;
                back.set(name, usual.get(name).expect("a number"))
                    .expect("in range");
                assert_eq!(back, usual);
                assert_ne!(variant.numbers, usual);
            }
        }
        assert!(all.len() > VerdictConfig::NUMBERS.len());
    }
}
