//! Chatter detectors judged on a population of machines that none of them has heard.
//!
//! Every cut is drawn, played once, and given to every detector with every way the speed
//! is told, so that differences are those of detector and telling. The detectors are
//! [`detectors::ALL`]; what came of many cuts is a [`Tally`], told by [`records`] and [`page`].
//!
//! ```no_run
//! use rarma_core::verdict::VerdictConfig;
//! use rarma_population::{Asked, Tally, Told, judged};
//!
//! let asked = Asked {
//!     tellings: vec![Told::None],
//!     detectors: vec![0],
//!     curve: false,
//!     before: None,
//!     numbers: VerdictConfig::default(),
//!     variants: Vec::new(),
//!     changed: false,
//! };
//! let mut tally = Tally::default();
//! for seed in 0..8 {
//!     tally.add(&judged(seed, &asked)?);
//! }
//! # Ok::<(), rarma_population::Defect>(())
//! ```

pub mod changed;
pub mod detectors;
pub mod labels;
pub mod page;
pub mod records;
pub mod score;
pub mod sensitivity;
pub mod tally;
pub mod told;

use changed::Flips;
use detectors::{ALL, Recording, Said};
use rarma_core::verdict::VerdictConfig;
use rarma_plants::population::Cut;
use rarma_plants::population::before::Before;
use rarma_plants::population::heard::Heard;
use score::{Score, judge};
use sensitivity::Variant;
use std::fmt;
use std::time::Instant;
pub use tally::Tally;
pub use told::Told;

/// What plant or monitor refused, in words: a defect of the population.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Defect(pub String);

impl fmt::Display for Defect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Defect {}

/// What was asked of whom: telling, place of the detector in [`ALL`], and that of the
/// threshold among its own; the first is its usual one.
pub type Question = (Told, usize, usize);

/// What came of a question.
#[derive(Debug)]
pub struct Answer {
    /// The question.
    pub question: Question,
    /// What was said.
    pub said: Said,
    /// What it is worth.
    pub score: Score,
}

/// A cut with what came of it.
#[derive(Debug)]
pub struct Judged {
    /// The cut.
    pub cut: Cut,
    /// As recorded.
    pub heard: Heard,
    /// All questions.
    pub answers: Vec<Answer>,
    /// What the variants of the verdict made of it, where they were asked.
    pub variants: Vec<Score>,
    /// What each of [`changed::CHANGES`] did to the monitor's answer, where that was asked.
    pub flips: Vec<Flips>,
    /// Time it took to draw, to play and to judge, s.
    pub took_s: [f64; 3],
}

/// Who is asked, and how.
#[derive(Debug, Clone)]
pub struct Asked {
    /// How the speed is told.
    pub tellings: Vec<Told>,
    /// Places of the detectors in [`ALL`].
    pub detectors: Vec<usize>,
    /// All thresholds of those, too, that have to listen anew for each.
    pub curve: bool,
    /// What a box has heard before each cut; what is said is told in the cut's time.
    pub before: Option<Before>,
    /// Numbers of the verdict.
    pub numbers: VerdictConfig,
    /// Other numbers that are tried beside them, with the first telling.
    pub variants: Vec<Variant>,
    /// The monitor listens to every cut changed in ways that should not matter, too, with
    /// the first telling.
    pub changed: bool,
}

/// Draws, plays and judges the cut of one seed.
///
/// # Errors
/// What plant or monitor refuse: a defect of the population.
pub fn judged(seed: u64, asked: &Asked) -> Result<Judged, Defect> {
    let failed = |why| Defect(format!("seed {seed}: {why}"));
    let clock = Instant::now();
    let cut = Cut::draw(seed).map_err(failed)?;
    let drawn_s = clock.elapsed().as_secs_f64();
    let heard = cut.hear().map_err(failed)?;
    let (mut before_s, mut alone_s) = (0.0, 0.0);
    let mut all = heard.clone();
    if let Some(before) = asked.before {
        all.samples = before.samples(&cut, &heard).map_err(failed)?;
        before_s = all.samples.len() as f64 / heard.fs_hz;
        alone_s = before.alone_s();
        all.samples.extend(&heard.samples);
    }
    let played_s = clock.elapsed().as_secs_f64();
    let mut answers: Vec<Answer> = Vec::new();
    for place in &asked.detectors {
        let detector = ALL[*place];
        let thresholds = match detector.thresholds() {
            all if asked.curve || !detector.listens_anew() => all,
            all => &all[..all.len().min(1)],
        };
        let mut last: Option<Vec<Said>> = None;
        for told in &asked.tellings {
            let said = match last.take().filter(|_| !detector.asks_speed()) {
                Some(same) => same,
                None => {
                    let speed = told.speed(&cut).later(-before_s);
                    let aliased = cut.sensor.folds > 1;
                    let mut recording = Recording::new(&all, speed, cut.teeth(), aliased);
                    recording.numbers = asked.numbers;
                    let mut said = detector.listen(&recording, thresholds)?;
                    said.iter_mut().for_each(|said| said.begin_later(before_s));
                    said
                }
            };
            answers.extend(said.iter().enumerate().map(|(k, said)| Answer {
                question: (*told, *place, k),
                score: judge(&cut, &heard, said, alone_s),
                said: said.clone(),
            }));
            last = Some(said);
        }
    }
    let (mut variants, mut flips) = (Vec::new(), Vec::new());
    if let Some(told) = asked.tellings.first() {
        let aliased = cut.sensor.folds > 1;
        let mut recording = Recording::new(&heard, told.speed(&cut), cut.teeth(), aliased);
        variants = sensitivity::scores(&cut, &heard, &recording, &asked.variants)?;
        if asked.changed {
            recording.numbers = asked.numbers;
            flips = changed::flips(&cut, &heard, &recording)?;
        }
    }
    let took_s = [
        drawn_s,
        played_s - drawn_s,
        clock.elapsed().as_secs_f64() - played_s,
    ];
    Ok(Judged {
        cut,
        heard,
        answers,
        variants,
        flips,
        took_s,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::detectors::named;

    /// A cut that begins in air is called at the same time, whatever was heard of the room before.
    #[test]
    fn what_was_heard_before_shifts_nothing() {
        let asked = |before| Asked {
            tellings: vec![Told::Exact, Told::Live],
            detectors: named("verdict").into_iter().collect(),
            curve: false,
            before,
            numbers: VerdictConfig::default(),
            variants: Vec::new(),
            changed: false,
        };
        let mut called = 0;
        for seed in 0..12 {
            let alone = judged(seed, &asked(None)).expect("judged");
            let after = judged(seed, &asked(Some(Before::Air))).expect("judged");
            for (alone, after) in alone.answers.iter().zip(&after.answers) {
                assert_eq!(alone.question, after.question);
                assert_eq!(alone.score.quiet_s, after.score.quiet_s);
                assert_eq!(alone.score.before, 0);
                let on_s = |answer: &Answer| answer.said.alarms.first().map(|a| a.on_s);
                if let (Some(alone), Some(after)) = (on_s(alone), on_s(after))
                    && (alone - after).abs() < 0.051
                {
                    called += 1;
                }
            }
        }
        assert!(called >= 6, "{called}");
    }
}
