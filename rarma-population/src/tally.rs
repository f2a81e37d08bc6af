//! All cuts together.

use super::changed::Flips;
use super::{Judged, Question, Told};
use crate::score::Sum;
use std::collections::BTreeMap;

/// The name of cuts in which nobody could tell, among the kinds.
pub const UNDECIDABLE: &str = "undecidable (in no other figure)";

/// All cuts together.
#[derive(Debug, Default)]
pub struct Tally {
    /// Cuts.
    pub cuts: u32,
    /// Of them, with chatter that can be heard.
    pub chatters: u32,
    /// Cuts in which nobody could tell; they are in no sum but their own kind's.
    pub undecidable: u32,
    /// By question.
    pub sums: BTreeMap<Question, Sum>,
    /// At the usual threshold, by telling, detector and kind of cut.
    pub kinds: BTreeMap<(Told, usize, &'static str), Sum>,
    /// By variant of the verdict.
    pub variants: Vec<Sum>,
    /// By change of the recording.
    pub flips: Vec<Flips>,
}

impl Tally {
    /// Adds a cut.
    pub fn add(&mut self, judged: &Judged) {
        self.cuts += 1;
        self.chatters += u32::from(!judged.heard.chatter_s.is_empty());
        let undecidable = judged.cut.undecidable();
        self.undecidable += u32::from(undecidable);
        let kinds = if undecidable {
            vec![UNDECIDABLE]
        } else {
            judged.cut.kinds()
        };
        if !undecidable {
            self.variants
                .resize_with(judged.variants.len(), Sum::default);
            for (sum, score) in self.variants.iter_mut().zip(&judged.variants) {
                sum.add(score);
            }
            self.flips.resize(judged.flips.len(), Flips::default());
            for (sum, flips) in self.flips.iter_mut().zip(&judged.flips) {
                sum.add(*flips);
            }
        }
        for answer in &judged.answers {
            let (told, detector, threshold) = answer.question;
            if !undecidable {
                let sum = self.sums.entry(answer.question).or_default();
                sum.add(&answer.score);
            }
            if threshold == 0 {
                for kind in &kinds {
                    let sum = self.kinds.entry((told, detector, kind)).or_default();
                    sum.add(&answer.score);
                }
            }
        }
    }
}
